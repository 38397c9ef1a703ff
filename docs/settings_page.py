"""Writes docs/settings.md from the types of the settings.

python -m docs.settings_page      # after a change of server/settings.py; a test keeps them equal
"""

import types
import typing
from pathlib import Path
from typing import Any, Literal

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from server.settings import FILE_SUFFIX, PREFIX, Settings, is_file_variable

PAGE = Path(__file__).parent / "settings.md"
MIB = 1024 * 1024

TEXT = f"""# Settings

Written by `python -m docs.settings_page` from `server/settings.py`. Do not edit.

The server reads its settings once, at its start, from environment variables. Options of `campusloop serve`
win over variables. A value that cannot be used ends the start, and the message names each such variable.
`campusloop doctor` also names variables that begin with `{PREFIX}` and are no setting.

**Secrets in files.** `{PREFIX}NAME{FILE_SUFFIX.upper()}` is the path of a file that holds the value of the
text setting `NAME`. Line ends at the end of the file are removed. Giving both the variable and its file is an
error. Settings that may be given so are marked with F.

A path is relative to the folder in which the server is started. A switch is `true` or `false`.

| variable | type | default | bounds | |
|---|---|---|---|---|
"""

# The end of a setting's name -> its unit. The longest end that fits counts.
UNITS = {
    "_per_minute": "1/min",
    "_bytes_max": "bytes",
    "_bytes_min": "bytes",
    "_hours": "h",
    "_days": "d",
    "_s": "s",
}
KINDS: dict[Any, str] = {str: "text", int: "integer", float: "number", bool: "switch", Path: "path"}


def page() -> str:
    """The page as Markdown."""
    rows = (_row(name, field) for name, field in Settings.model_fields.items())
    return TEXT + "\n".join(rows) + "\n"


def _row(name: str, field: FieldInfo) -> str:
    variable = f"{PREFIX}{name.upper()}"
    mark = " F" if is_file_variable(f"{variable}{FILE_SUFFIX.upper()}") else ""
    unit = next((unit for end, unit in UNITS.items() if name.endswith(end)), "")
    kind = _kind(field.annotation) + (f", {unit}" if unit else "")
    cells = (f"`{variable}`{mark}", kind, _default(field, unit), _bounds(field), field.description or "")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _kind(annotation: Any) -> str:
    origin = typing.get_origin(annotation)
    if origin in (typing.Union, types.UnionType):
        return _kind(next(part for part in typing.get_args(annotation) if part is not type(None)))
    if origin is Literal:
        return " or ".join(f"`{value}`" for value in typing.get_args(annotation))
    return KINDS[annotation]


def _default(field: FieldInfo, unit: str) -> str:
    value = field.default
    if value is PydanticUndefined:
        return "required"
    if value is None or value == "":
        return "empty"
    if unit == "bytes" and value % MIB == 0:
        return f"{value} ({value // MIB} MiB)"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def _bounds(field: FieldInfo) -> str:
    """What the types say of a value, e.g. `> 0, <= 168`."""
    found = []
    for bound in field.metadata:
        for attribute, sign in (("gt", ">"), ("ge", ">="), ("lt", "<"), ("le", "<=")):
            limit = getattr(bound, attribute, None)
            if limit is not None:
                found.append(f"{sign} {limit}")
        if getattr(bound, "min_length", None) is not None:
            found.append(f"at least {bound.min_length} character")
        if getattr(bound, "max_length", None) is not None:
            found.append(f"at most {bound.max_length} characters")
        if getattr(bound, "pattern", None) is not None:
            found.append(f"`{bound.pattern}`")
    return ", ".join(found)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
