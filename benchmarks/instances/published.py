"""Shared by the benchmarks on published instances: finding them, best known costs, writing routes."""

import argparse
import csv
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from campusloop.studies.instances.instance import Instance, InstanceBroken
from campusloop.studies.instances.load import load_instance

_SUFFIXES = {".txt", ".json", ""}
_R_FILE = re.compile(r"R(\d+)([ab])")


def arguments(description: str | None) -> argparse.ArgumentParser:
    """The arguments of every benchmark on published instances."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--best-known", type=Path)
    parser.add_argument("--solutions", type=Path)
    parser.add_argument("--json", type=Path)
    return parser


def instances_in(folder: Path) -> list[Instance]:
    """Every instance of a folder, or the one in a file. A file that is none ends the program with its
    reason."""
    paths = [folder] if folder.is_file() else sorted(p for p in folder.glob("*") if p.suffix in _SUFFIXES)
    files = [path for path in paths if path.is_file()]
    if not files:
        sys.exit(f"{folder}: no instance files (.txt or .json) here")
    try:
        return [load_instance(path) for path in files]
    except InstanceBroken as error:
        sys.exit(str(error))


def best_known(folder: Path, table: Path | None, column: str) -> dict[str, float]:
    """instance -> the column's number, from the table or from best_known.csv in the folder or beside it."""
    base = folder.parent if folder.is_file() else folder
    places = [table] if table else [base / "best_known.csv", base.parent / "best_known.csv"]
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        if table:
            sys.exit(f"{table}: there is no such file")
        return {}
    with found.open(encoding="utf-8", newline="") as file:
        return {row["instance"]: float(row[column]) for row in csv.DictReader(file)}


def write_routes(folder: Path | None, name: str, routes: Sequence[Sequence[int]]) -> None:
    """One file an instance, one line a vehicle: node numbers in order, the depot left out."""
    if folder is None:
        return
    folder.mkdir(parents=True, exist_ok=True)
    lines = (" ".join(str(node) for node in route) for route in routes)
    (folder / f"{name}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def published_name(name: str) -> str:
    """R1a..R10a are pr01..pr10, R1b..R10b are pr11..pr20."""
    match = _R_FILE.fullmatch(name)
    if match is None:
        return name
    return f"pr{int(match[1]) + (10 if match[2] == 'b' else 0):02d}"
