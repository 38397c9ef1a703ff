"""What is left of the errors of a map that was made, as a table."""

from collections.abc import Mapping

from rich.console import Console
from rich.table import Table


def print_residuals(console: Console, residuals: Mapping[str, float]) -> None:
    """A row for each; their names tell the units."""
    table = Table(title="residuals", title_justify="left")
    table.add_column("name")
    table.add_column("value", justify="right")
    for name, value in residuals.items():
        table.add_row(name, f"{value:.4g}")
    console.print(table)
