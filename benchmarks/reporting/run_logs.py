"""Run logs of benchmark drives, for the web viewer, Foxglove and bit-for-bit replay."""

import argparse
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class LogChoice:
    """folder: where run logs go, None: nowhere. only: of runs in whose name this occurs, "" for all."""

    folder: Path | None
    only: str = ""

    def of(self, name: str) -> Path | None:
        """Where this run's log goes, or None when none is kept."""
        return self.folder if self.folder is not None and self.only in name else None


def add_log_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--logs",
        type=Path,
        help="folder for run logs (MCAP): `campusloop view DIR` shows them, Foxglove opens them",
    )
    parser.add_argument("--logs-of", default="", metavar="TEXT", help="only of runs in whose name this is")


def log_choice(arguments: argparse.Namespace) -> LogChoice:
    """Raises SystemExit when there are run logs in the folder already: a log is written once."""
    folder: Path | None = arguments.logs
    if folder is not None and any(folder.rglob("*.mcap")):
        raise SystemExit(f"{folder} holds run logs already; give another --logs")
    return LogChoice(folder, arguments.logs_of)
