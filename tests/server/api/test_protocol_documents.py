from pathlib import Path

import pytest
import yaml

from docs.protocol.build import FOLDER, documents

DOCUMENTS = documents()


@pytest.mark.parametrize("name", sorted(DOCUMENTS))
def test_the_document_on_disk_is_what_the_code_speaks(name: str) -> None:
    written = Path(FOLDER / name).read_text(encoding="utf-8")
    assert written == DOCUMENTS[name], "run `python -m docs.protocol.build`"


@pytest.mark.parametrize("name", sorted(DOCUMENTS))
def test_every_reference_leads_somewhere(name: str) -> None:
    document = yaml.safe_load(DOCUMENTS[name])
    for reference in _references(document):
        place = document
        for step in reference.removeprefix("#/").split("/"):
            place = place[step]


def _references(node: object) -> list[str]:
    if isinstance(node, dict):
        own = [node["$ref"]] if isinstance(node.get("$ref"), str) else []
        return own + [ref for value in node.values() for ref in _references(value)]
    if isinstance(node, list):
        return [ref for value in node for ref in _references(value)]
    return []
