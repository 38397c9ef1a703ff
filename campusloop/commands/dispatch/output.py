"""The output of these commands: JSON results, and the exit with an error message."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console

BAD_INPUT = 2

JsonPath = Annotated[
    Path | None, typer.Option("--json", metavar="FILE", help="write the result here; - for standard output")
]


def refuse(errors: Console, text: str) -> NoReturn:
    errors.print(text, style="red", markup=False, highlight=False, soft_wrap=True)
    raise typer.Exit(BAD_INPUT)


def write_json(errors: Console, path: Path, report: Any) -> bool:
    """Returns True if the JSON went to standard output; then nothing else may be printed there."""
    text = json.dumps(report, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
        return True
    try:
        path.write_text(text)
    except OSError as error:
        refuse(errors, f"{path}: {error.strerror}")
    return False
