"""The official AsyncAPI parser on the documents of the sockets."""

from pathlib import Path

import pytest
import yaml

from docs.protocol.build import documents
from tests.server.api.specifications.web_tools import asyncapi_problems, needs_web_tools

pytestmark = [pytest.mark.real, needs_web_tools]
DOCUMENTS = documents()


@pytest.mark.parametrize("name", sorted(DOCUMENTS))
def test_the_parser_finds_nothing(name: str, tmp_path: Path) -> None:
    assert asyncapi_problems(DOCUMENTS[name], tmp_path) == []


def test_the_parser_refuses_a_document_with_a_payload_that_is_no_schema(tmp_path: Path) -> None:
    document = yaml.safe_load(DOCUMENTS["live.asyncapi.yaml"])
    document["components"]["schemas"]["Delta"]["discriminator"] = {"propertyName": "type"}
    problems = asyncapi_problems(yaml.safe_dump(document), tmp_path)
    assert any("discriminator" in problem for problem in problems)
