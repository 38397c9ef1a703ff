"""Parses lines of numbers, with errors that name the line."""

import math

from campusloop.studies.instances.instance import InstanceBroken


def numbered_rows(name: str, text: str) -> list[tuple[int, list[float]]]:
    """(line number, its numbers) of every line that is not empty. Raises InstanceBroken."""
    rows = []
    for number, line in enumerate(text.splitlines(), start=1):
        fields = line.split()
        if not fields:
            continue
        try:
            values = [float(field) for field in fields]
        except ValueError as error:
            raise InstanceBroken(
                f"{name}, line {number}: expected numbers, found {line.strip()!r}"
            ) from error
        if not all(map(math.isfinite, values)):
            raise InstanceBroken(f"{name}, line {number}: a value is not finite")
        rows.append((number, values))
    if not rows:
        raise InstanceBroken(f"{name}: the file is empty")
    return rows


def whole(name: str, line: int, what: str, value: float) -> int:
    """A number that counts something. Raises InstanceBroken."""
    if value != int(value):
        raise InstanceBroken(f"{name}, line {line}: {what} must be a whole number, found {value:g}")
    return int(value)
