"""The parameter tables of docs/: what an engineer who tunes by them takes for the default."""

import ast
import inspect
import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

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


def defaults(source: Any) -> dict[str, float]:
    """The public numbers that a module defines, or a class is given by default, by name."""
    if isinstance(source, type):
        found = {name: given.default for name, given in inspect.signature(source).parameters.items()}
    else:
        found = {name: vars(source)[name] for name in _assigned(source)}
    return {
        name: float(value)
        for name, value in found.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }


def _assigned(module: Any) -> Iterator[str]:
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.Assign):
            yield from (t.id for t in node.targets if isinstance(t, ast.Name) and not t.id.startswith("_"))


def differing(page: str, sources: Iterable[Any]) -> list[str]:
    """Names of which a page gives another value than the modules and classes that it documents, or none.

    AssertionError for a source of which the page says nothing.
    """
    documented = documented_defaults([page])
    wrong = []
    for source in sources:
        known = defaults(source)
        shared = known.keys() & documented.keys()
        assert shared, f"docs/{page} documents nothing of {source.__name__}"
        wrong += [f"{source.__name__}.{name} is not documented" for name in sorted(known.keys() - shared)]
        wrong += [
            f"{source.__name__}.{name} is {known[name]:g}, the page says {documented[name]}"
            for name in sorted(shared)
            if not any(math.isclose(value, known[name]) for value in documented[name])
        ]
    return wrong


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
