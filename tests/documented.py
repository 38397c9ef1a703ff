"""The parameter tables of docs/: what an engineer who tunes by them takes for the default."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
_SCALES = {"ms": 1e6, "s": 1e9, "us": 1e3}
_NUMBER = re.compile(r"([+-]?[\d,]*\d(?:\.\d+)?(?:e-?\d+)?)\s*([a-zA-Z/0-9]*)$")


def documented_defaults(pages: Iterable[str]) -> dict[str, set[float]]:
    """Every value that a table with the columns name, default, unit gives a name; times in the unit of the
    name's ending.
    """
    found: dict[str, set[float]] = {}
    for page in pages:
        for names, values, units in _rows((DOCS / page).read_text(encoding="utf-8")):
            for number, name in enumerate(names):
                value = _value(name, values, units, number)
                if value is not None:
                    found.setdefault(name, set()).add(value)
    return found


def _rows(text: str) -> Iterator[tuple[list[str], list[str], list[str]]]:
    inside = False
    for line in text.splitlines():
        if not line.startswith("|"):
            inside = False
            continue
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if cells[:2] in (["name", "default"], ["parameter", "default"]):
            inside = True
        elif inside and len(cells) >= 3:
            names = [name.rpartition(".")[2] for name in re.findall(r"`([\w.]+)`", cells[0])]
            yield names, re.split(r",\s+|\s\+\s", cells[1]), re.split(r",\s*", cells[2])


def _value(name: str, values: list[str], units: list[str], number: int) -> float | None:
    if number >= len(values):
        return None
    match = _NUMBER.match(values[number])
    if match is None:
        return None
    unit = match[2] or (units[number] if number < len(units) else units[0])
    value = float(match[1].replace(",", ""))
    return value * _SCALES[unit] if "_ns" in name.lower() and unit in _SCALES else value
