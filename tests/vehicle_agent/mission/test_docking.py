"""When a vehicle that stands before its stop has arrived."""

import pytest

from tests.vehicle_agent.mission.ring import STEP_NS, RingShuttle, a_visit, an_order, rest

STOP = ("south", 40.0)


def standing_short(short_m: float) -> RingShuttle:
    """A shuttle that has just come to stand this far before its stop."""
    shuttle = RingShuttle()
    shuttle.stops_short_m = short_m
    shuttle.go(an_order((a_visit("a", *STOP), rest(STOP))))
    shuttle.run(2.0)
    shuttle.run_until(lambda: shuttle.state.standing_since_ns > 0)
    return shuttle


def opens_after_s(shuttle: RingShuttle) -> float:
    began_ns = shuttle.now_ns
    shuttle.run_until(lambda: shuttle.state.stage == "serving", 10.0)
    return (shuttle.now_ns - began_ns) * 1e-9


@pytest.mark.parametrize(("short_m", "after_s"), [(0.05, 0.3), (0.15, 0.3), (0.3, 3.0), (0.45, 3.0)])
def test_a_vehicle_opens_its_doors_at_once_when_docked_and_after_3_s_when_short_of_it(
    short_m: float, after_s: float
) -> None:
    assert opens_after_s(standing_short(short_m)) == pytest.approx(after_s, abs=2 * STEP_NS * 1e-9)


def test_a_vehicle_that_drives_on_to_its_stop_opens_its_doors_there() -> None:
    shuttle = standing_short(0.4)
    shuttle.run(1.0)
    assert shuttle.state.stage == "driving"
    shuttle.stops_short_m = 0.0
    assert opens_after_s(shuttle) < 2.0
    assert shuttle.state.s_m == pytest.approx(STOP[1], abs=0.05)


def test_a_vehicle_that_stands_farther_away_has_not_arrived() -> None:
    shuttle = standing_short(0.6)
    shuttle.run(10.0)
    assert shuttle.state.stage == "driving"
