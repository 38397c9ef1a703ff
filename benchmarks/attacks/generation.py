"""Cases of a described operation, from a seed."""

import warnings
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import HypothesisDeprecationWarning, Unsatisfiable


def cases(operation: Any, number: int, count: int) -> list[Any]:
    """At most so many; none if its description allows none."""
    made: list[Any] = []

    @seed(number)
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(case=operation.as_strategy())
    def collect(case: Any) -> None:
        made.append(case)

    try:
        with warnings.catch_warnings():
            # Of the generator's own use of chance.
            warnings.simplefilter("ignore", HypothesisDeprecationWarning)
            collect()
    except Unsatisfiable:
        return []
    return made
