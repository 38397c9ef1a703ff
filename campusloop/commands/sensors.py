"""`campusloop sensors`: whether sensors send what they should."""

from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from campusloop.operations.sensor_check import (
    FORMS,
    LiveSource,
    SourceNameError,
    is_live,
    listen,
    open_source,
    open_vehicle,
)
from vehicle_agent.receivers.gnss_receiver import ReceiverError
from workshop.clouds.errors import CloudFileError
from workshop.sensors.recorded import check_recorded
from workshop.sensors.source_report import SourceReport

app = typer.Typer(no_args_is_help=True)
# A group of one command would be that command.
app.callback()(lambda: None)
console = Console()

EXIT_FINDINGS, EXIT_BAD_INPUT = 1, 2


@app.command("check")
def check_sensors(
    sources: Annotated[
        list[str],
        typer.Argument(
            help=f"Live sources ({FORMS}), bags, folders of scans, a receiver's bytes (.nmea, .ubx)."
        ),
    ],
    seconds: Annotated[
        float, typer.Option(min=0.2, max=600.0, help="How long live sources are listened to.")
    ] = 5.0,
) -> None:
    """Show of each source its rate, latency, clock and what is wrong; exits with 1 if anything is."""
    live: list[LiveSource] = []
    reports: list[SourceReport] = []
    try:
        for name in sources:
            if is_live(name):
                live.append(open_source(name))
            elif name.endswith(".toml"):
                live += open_vehicle(Path(name))
            else:
                reports += check_recorded(Path(name))
        if live:
            console.print(f"listening for {seconds:g} s", highlight=False)
            reports += listen(live, seconds)
    except (SourceNameError, CloudFileError, ReceiverError) as error:
        _refuse(str(error))
    finally:
        for opened in live:
            opened.source.close()
    _print_reports(reports)
    if any(report.findings for report in reports):
        raise typer.Exit(EXIT_FINDINGS)


def _print_reports(reports: list[SourceReport]) -> None:
    table = Table()
    for heading in ("source", "what", "messages", "rate (Hz)", "latency (ms)", "clock"):
        table.add_column(
            heading, justify="right" if heading.endswith(")") or heading == "messages" else "left"
        )
    for report in reports:
        rate = "" if report.rate_hz is None else f"{report.rate_hz:.2f}"
        latency = "" if report.latency_ms is None else f"{report.latency_ms:.1f}"
        table.add_row(report.name, report.what, str(report.messages), rate, latency, report.clock)
    console.print(table)
    for report in reports:
        for finding in report.findings:
            console.print(f"{report.name}: {finding}", soft_wrap=True, highlight=False, markup=False)


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", soft_wrap=True, highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)
