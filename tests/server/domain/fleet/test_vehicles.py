"""Which vehicles get new rides."""

from dataclasses import replace
from datetime import UTC, datetime

import pytest

from server.domain.fleet.vehicles import Vehicle

READY = Vehicle(
    "campus",
    "shuttle-1",
    "Shuttle 1",
    6,
    1,
    datetime(2026, 11, 23, 8, 0, tzinfo=UTC),
    connected=True,
    mode="autonomous",
    held=False,
    placed=True,
)


def test_a_connected_placed_shuttle_in_service_gets_rides() -> None:
    assert READY.accepts_rides


@pytest.mark.parametrize(
    "change",
    [{"connected": False}, {"held": True}, {"placed": False}, {"in_service": False}, {"retired": True}],
)
def test_each_reason_alone_keeps_a_shuttle_from_new_rides(change: dict[str, bool]) -> None:
    assert not replace(READY, **change).accepts_rides  # type: ignore[arg-type]


def test_a_shuttle_that_was_only_enrolled_gets_no_rides() -> None:
    assert not Vehicle("campus", "s", "S", 6, 1, READY.enrolled_at).accepts_rides
