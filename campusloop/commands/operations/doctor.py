"""`campusloop doctor`: checks an installation and says what to mend."""

import json
import os
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from campusloop.operations.examination import examine
from campusloop.operations.finding import Finding

EXIT_BAD = 1
_STYLES = {"good": "green", "warning": "yellow", "bad": "red"}


def doctor(
    host: Annotated[str | None, typer.Option(help="As for `serve`.")] = None,
    port: Annotated[int | None, typer.Option(help="As for `serve`.")] = None,
    tls_cert: Annotated[Path | None, typer.Option(help="As for `serve`.")] = None,
    tls_key: Annotated[Path | None, typer.Option(help="As for `serve`.")] = None,
    campus_map: Annotated[Path | None, typer.Option("--map", help="As for `serve`.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
) -> None:
    """Check everything that the server needs. Ends with 1 if anything is bad."""
    findings = examine(
        os.environ, datetime.now(UTC),
        host=host, port=port, tls_cert=tls_cert, tls_key=tls_key, map_path=campus_map,
    )  # fmt: skip
    if as_json:
        typer.echo(json.dumps([asdict(finding) for finding in findings], indent=1))
    else:
        console = Console(soft_wrap=True, highlight=False)
        for finding in findings:
            console.print(_line(finding))
    if any(finding.state == "bad" for finding in findings):
        raise typer.Exit(EXIT_BAD)


def _line(finding: Finding) -> Text:
    line = Text(f"{finding.state:<8}", style=_STYLES[finding.state])
    line.append(f"{finding.check:<10}{finding.text}", style="default")
    if finding.remedy:
        line.append(f" -> {finding.remedy}", style="default")
    return line
