"""docker-compose.yml as data, with its variables filled in."""

import re
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[3]
PATH = ROOT / "docker-compose.yml"
_VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")


def compose_file(**variables: str) -> dict[str, Any]:
    """The file with these variables, and the defaults of the others."""

    def value(found: re.Match[str]) -> str:
        name, default = found.groups()
        if name not in variables and default is None:
            raise KeyError(f"${{{name}}} has no default")
        return variables.get(name, default)

    document: dict[str, Any] = yaml.safe_load(_VARIABLE.sub(value, PATH.read_text()))
    return document
