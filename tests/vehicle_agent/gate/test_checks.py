"""Which sets of commands go on to the bus, each limit from both sides."""

from typing import Any

import pytest

from vehicle_agent.can.braking import CommandedActuation, CommandSetError
from vehicle_agent.config import Profile
from vehicle_agent.gate.checks import CommandChecks
from vehicle_agent.gate.settings import gate_settings
from vehicle_agent.signals import CanFrame

SETTINGS = gate_settings(Profile())
TICK_NS = 20_000_000
S_NS = 1_000_000_000
REACH_RAD = SETTINGS.rate_slack * SETTINGS.steer_rate_radps_max * 0.02 + SETTINGS.angle_slack_rad


class PlainByWire:
    """A by-wire whose frames need no decoding: they stand for the actuation given beside them."""

    frame_gap_ns = 0
    counter_steps = 16

    def __init__(self) -> None:
        self.next: CommandedActuation

    def command_ids(self) -> frozenset[int]:
        return frozenset({1})

    def commanded(self, frames: tuple[CanFrame, ...]) -> CommandedActuation:
        return self.next

    def braking_frames(self, *_: Any) -> tuple[CanFrame, ...]:
        raise AssertionError("checks brake nothing")


class Sets:
    """A row of sets, 20 ms apart unless a test says otherwise."""

    def __init__(self) -> None:
        self.by_wire = PlainByWire()
        self.checks = CommandChecks(self.by_wire, SETTINGS)
        self.now_ns, self.counter = S_NS, 0

    def take(
        self,
        steer_rad: float = 0.0,
        enable: bool = True,
        steps: int = 1,
        age_ns: int = 0,
        after_ns: int = TICK_NS,
    ) -> str:
        """Why it is refused; "" when it is accepted."""
        self.now_ns += after_ns
        counter = (self.counter + steps) % 16
        self.by_wire.next = CommandedActuation(counter, enable, steer_rad, 0.0, 0.0)
        try:
            accepted = self.checks.accepted((CanFrame(self.now_ns - age_ns, 1, b""),), self.now_ns)
        except CommandSetError as error:
            return str(error)
        assert accepted is self.by_wire.next
        self.counter = counter
        return ""


@pytest.mark.parametrize(
    ("age_ns", "refused"),
    [
        (0, ""),
        (SETTINGS.late_ns, ""),
        (SETTINGS.late_ns + 1, "the set is stale"),
        (-SETTINGS.early_ns, ""),
        (-SETTINGS.early_ns - 1, "the set is stamped in the future"),
    ],
)
def test_a_set_may_be_two_ticks_old_and_hardly_from_the_future(age_ns: int, refused: str) -> None:
    assert Sets().take(age_ns=age_ns) == refused


@pytest.mark.parametrize(
    ("steps", "refused"),
    [(0, "the counter stands still"), (16, "the counter stands still"), (1, ""), (3, "")]
    + [(steps, "the set is out of order") for steps in (4, 8, 15)],
)
def test_counters_go_up_by_one_and_over_two_that_are_lost(steps: int, refused: str) -> None:
    sets = Sets()
    assert sets.take() == ""
    assert sets.take(steps=steps) == refused


@pytest.mark.parametrize(
    ("after_ns", "refused"), [(SETTINGS.fresh_ns, "the set is out of order"), (SETTINGS.fresh_ns + 1, "")]
)
def test_after_a_silence_any_other_counter_is_a_new_beginning(after_ns: int, refused: str) -> None:
    sets = Sets()
    assert sets.take() == ""
    assert sets.take(steps=9, after_ns=after_ns) == refused


def test_a_refused_set_is_not_the_one_that_the_next_is_compared_with() -> None:
    sets = Sets()
    assert sets.take() == ""
    assert sets.take(steps=7) == "the set is out of order"
    assert sets.take(steps=1, after_ns=0) == ""


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_wheel_is_not_steered_beyond_its_lock(side: float) -> None:
    most_rad = SETTINGS.steer_rad_max + SETTINGS.angle_slack_rad
    assert Sets().take(side * (most_rad - 1e-6)) == ""
    assert Sets().take(side * (most_rad + 1e-6)) == "the steering angle is beyond its limit"


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_wheel_is_not_steered_faster_than_it_turns(side: float) -> None:
    for reach_rad, refused in ((REACH_RAD - 1e-6, ""), (REACH_RAD + 1e-6, "the steering angle jumps")):
        sets = Sets()
        assert sets.take(side * 0.1) == ""
        assert sets.take(side * (0.1 + reach_rad)) == refused


def test_after_a_lost_set_the_wheel_may_have_turned_farther_and_sets_at_once_no_farther() -> None:
    late, at_once = Sets(), Sets()
    assert (late.take(), at_once.take()) == ("", "")
    assert late.take(1.5 * REACH_RAD, steps=2, after_ns=2 * TICK_NS) == ""
    assert at_once.take(REACH_RAD - 1e-6, after_ns=1) == ""
    assert at_once.take(2.1 * REACH_RAD, after_ns=1) == "the steering angle jumps"


@pytest.mark.parametrize(("before", "now"), [(False, True), (True, False), (False, False)])
def test_only_between_two_sets_that_steer_an_angle_can_jump(before: bool, now: bool) -> None:
    """Without by-wire the commanded angle follows the driver's wheel."""
    sets = Sets()
    assert sets.take(0.0, enable=before) == ""
    assert sets.take(0.4, enable=now) == ""
