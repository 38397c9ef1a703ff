"""Pages by position: the rows that come after the last row of the page before."""

from collections.abc import Sequence
from typing import Any

from sqlalchemy import and_, or_
from sqlalchemy.sql import ColumnElement


def rows_after(
    order: Sequence[tuple[ColumnElement[Any], bool]], position: Sequence[object]
) -> ColumnElement[bool]:
    """The condition that a row comes after `position` in this order; (column, it descends) for each step.

    A comparison of whole rows would need all columns to run the same way.
    """
    equal: list[ColumnElement[bool]] = []
    steps: list[ColumnElement[bool]] = []
    for (column, descends), value in zip(order, position, strict=True):
        steps.append(and_(*equal, column < value if descends else column > value))
        equal.append(column == value)
    return or_(*steps)
