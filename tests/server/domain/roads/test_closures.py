"""A closure's life: sound or not, its time, its end."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.domain.errors import ClosureInvalid, ClosureOver
from server.domain.roads.closures import Closure, ClosureState, due, ends_of, lifted, require_sound

NOON = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)
HOUR, MOMENT = timedelta(hours=1), timedelta(microseconds=1)
CLOSURE = Closure("snow-lion", "c-1", ("l",), (), "water main", NOON, NOON + HOUR, "ann", NOON - HOUR)


@pytest.mark.parametrize(
    ("now", "state"),
    [
        (NOON - MOMENT, ClosureState.SCHEDULED),
        (NOON, ClosureState.IN_FORCE),
        (NOON + HOUR - MOMENT, ClosureState.IN_FORCE),
        (NOON + HOUR, ClosureState.OVER),
    ],
)
def test_a_closure_holds_from_its_beginning_until_its_end(now: datetime, state: ClosureState) -> None:
    assert due(CLOSURE, now).state is state


def test_a_closure_without_an_end_stays_in_force() -> None:
    assert due(replace(CLOSURE, ends_at=None), NOON + 10_000 * HOUR).state is ClosureState.IN_FORCE


def test_a_closure_that_was_lifted_does_not_come_back() -> None:
    gone = lifted(CLOSURE, "bob")
    assert (gone.state, gone.lifted_by) == (ClosureState.OVER, "bob")
    assert due(gone, NOON) == gone
    with pytest.raises(ClosureOver, match="c-1"):
        lifted(gone, "ann")


@pytest.mark.parametrize(
    "changes",
    [
        {"lane_ids": ()},
        {"ends_at": NOON},
        {"ends_at": NOON - MOMENT},
        {"starts_at": NOON - 3 * HOUR, "ends_at": NOON - HOUR},
    ],
)
def test_a_closure_of_nothing_or_of_no_time_to_come_is_refused(changes: dict[str, object]) -> None:
    with pytest.raises(ClosureInvalid):
        require_sound(replace(CLOSURE, **changes))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"ends_at": None},
        {"lane_ids": (), "section_ids": ("l/0",)},
        {"ends_at": NOON + MOMENT},
        {"starts_at": NOON - 3 * HOUR, "ends_at": NOON - HOUR + MOMENT},
    ],
)
def test_a_closure_of_some_road_for_some_time_is_sound(changes: dict[str, object]) -> None:
    require_sound(replace(CLOSURE, **changes))  # type: ignore[arg-type]


def test_ends_come_in_order_each_once() -> None:
    later = replace(CLOSURE, ends_at=NOON + 2 * HOUR)
    assert ends_of((later, CLOSURE, CLOSURE, replace(CLOSURE, ends_at=None))) == [
        NOON + HOUR,
        NOON + 2 * HOUR,
    ]


def test_incidents_name_the_closure_and_its_reason() -> None:
    assert CLOSURE.label == "closure c-1 (water main)"
    assert replace(CLOSURE, reason="").label == "closure c-1"


@given(
    starts_h=st.integers(0, 6),
    lasts_h=st.one_of(st.none(), st.integers(1, 6)),
    begins_h=st.integers(0, 8),
    takes_h=st.integers(0, 4),
    state=st.sampled_from(list(ClosureState)),
)
def test_a_drive_meets_a_closure_that_holds_at_some_time_of_it(
    starts_h: int, lasts_h: int | None, begins_h: int, takes_h: int, state: ClosureState
) -> None:
    ends_at = None if lasts_h is None else NOON + (starts_h + lasts_h) * HOUR
    closure = replace(CLOSURE, starts_at=NOON + starts_h * HOUR, ends_at=ends_at, state=state)
    hours = range(begins_h, begins_h + takes_h + 1)
    holds = any(starts_h <= hour and (lasts_h is None or hour < starts_h + lasts_h) for hour in hours)
    met = closure.overlaps(NOON + begins_h * HOUR, NOON + (begins_h + takes_h) * HOUR)
    assert met == (holds and state is not ClosureState.OVER)
