"""Run logs of benchmark drives, for the web viewer, Foxglove and bit-for-bit replay."""

import argparse
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class LogChoice:
    """folder: of run logs, None for no logs. only: for runs whose name contains this text."""

    folder: Path | None
    only: str = ""

    def of(self, name: str) -> Path | None:
        """The folder of this run's log, or None for no log."""
        return self.folder if self.folder is not None and self.only in name else None


def add_log_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--logs",
        type=Path,
        help="folder for run logs (MCAP): `campusloop view DIR` shows them, Foxglove opens them",
    )
    parser.add_argument("--logs-of", default="", metavar="TEXT", help="only of runs in whose name this is")


def log_choice(arguments: argparse.Namespace) -> LogChoice:
    """Raises SystemExit if the folder has run logs already: a log is written once."""
    folder: Path | None = arguments.logs
    if folder is not None and any(folder.rglob("*.mcap")):
        raise SystemExit(f"{folder} holds run logs already; give another --logs")
    return LogChoice(folder, arguments.logs_of)
