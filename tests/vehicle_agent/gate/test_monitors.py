"""What the gate sees for itself, each monitor at its own limit."""

import math

import numpy as np
import pytest

from vehicle_agent.can.braking import CommandedActuation
from vehicle_agent.config import Profile
from vehicle_agent.gate.monitors import FootprintMonitor, SpeedMonitor, SteeringMonitor
from vehicle_agent.gate.settings import gate_settings
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, ObstaclePercept, TrackPercept, VehicleMotion

SETTINGS = gate_settings(Profile())
TICK_NS = 20_000_000
S_NS = 1_000_000_000
DELAY_NS = round(1e9 * SETTINGS.steer_delay_s)
FRONT_M, HALF_M = SETTINGS.front_m, SETTINGS.half_width_m
SPEED_MPS = 4.0
STOPPING_M = SPEED_MPS * SETTINGS.delay_s + SPEED_MPS**2 / (2.0 * SETTINGS.brake_mps2)


def a_motion(
    stamp_ns: int = S_NS, speed_mps: float = SPEED_MPS, steer_rad: float = 0.0, enabled: bool = True
) -> VehicleMotion:
    return VehicleMotion(stamp_ns, speed_mps, steer_rad, 0.0, 0.0, enabled, False, True, 0.9)


def a_command(steer_rad: float = 0.0, brake: float = 0.0, enable: bool = True) -> CommandedActuation:
    return CommandedActuation(1, enable, steer_rad, 0.0, brake)


def cells(*places: tuple[float, float], stamp_ns: int = S_NS) -> ObstaclePercept:
    return ObstaclePercept(stamp_ns, np.array(places).reshape(-1, 2), np.ones(len(places)), 100)


def a_track(
    x: float,
    y: float,
    vx: float = 0.0,
    vy: float = 0.0,
    kind: int = PEDESTRIAN,
    size: tuple[float, float] = (0.5, 0.5),
    yaw: float = 0.0,
    stamp_ns: int = S_NS,
) -> TrackPercept:
    return TrackPercept(
        stamp_ns,
        np.array([1]),
        np.array([kind]),
        np.array([[x, y, yaw]]),
        np.array([[vx, vy]]),
        np.array([size]),
    )


def is_close(
    *seen: ObstaclePercept | TrackPercept,
    motion: VehicleMotion | None = None,
    asked: CommandedActuation | None = None,
    now_ns: int = S_NS,
) -> bool:
    """After more looks than are needed to be sure."""
    monitor = FootprintMonitor(SETTINGS)
    for percept in seen:
        monitor.take_percept(percept)
    answers = [
        monitor.is_close(motion or a_motion(now_ns), asked or a_command(), now_ns)
        for _ in range(SETTINGS.confirmed + 1)
    ]
    assert not any(answers[:-1]), "one look is not enough"
    return answers[-1]


# ------------------------------------------------------------ the footprint


def test_what_stands_within_the_stopping_way_is_close_and_what_stands_beyond_is_not() -> None:
    assert is_close(cells((FRONT_M + STOPPING_M, 0.0)))
    assert not is_close(cells((FRONT_M + STOPPING_M + SETTINGS.margin_m + 0.1, 0.0)))
    assert not is_close(cells((FRONT_M + 1.0, HALF_M + 0.05)))
    assert not is_close()


@pytest.mark.parametrize(
    "ends_it",
    [
        {"asked": a_command(brake=SETTINGS.braked_ratio)},
        {"asked": a_command(enable=False)},
        {"motion": a_motion(speed_mps=SETTINGS.standing_mps)},
    ],
)
def test_who_brakes_stands_or_is_not_driven_by_wire_is_left_alone(ends_it: dict[str, object]) -> None:
    wall = cells((FRONT_M + 0.3, 0.0))
    assert is_close(wall)
    assert not is_close(wall, **ends_it)  # type: ignore[arg-type]


def test_a_look_that_finds_nothing_begins_the_count_anew() -> None:
    monitor = FootprintMonitor(SETTINGS)
    monitor.take_percept(cells((FRONT_M + 0.5, 0.0)))
    for brake in (0.0, 0.0, 1.0, 0.0, 0.0):
        assert not monitor.is_close(a_motion(), a_command(brake=brake), S_NS)
    assert monitor.is_close(a_motion(), a_command(), S_NS)


def test_both_the_wheel_as_it_is_and_as_it_is_told_are_looked_along() -> None:
    aside = cells((FRONT_M + 1.0, 1.6))
    assert not is_close(aside)
    assert is_close(aside, motion=a_motion(steer_rad=0.35))
    assert is_close(aside, asked=a_command(steer_rad=0.35))
    assert not is_close(aside, asked=a_command(steer_rad=-0.35))


def test_what_was_seen_a_moment_ago_has_come_nearer_by_the_way_driven_since() -> None:
    later_ns = S_NS + SETTINGS.percept_ns
    driven_m = SPEED_MPS * SETTINGS.percept_ns * 1e-9
    wall = cells((FRONT_M + STOPPING_M + driven_m - 0.05, 0.0))
    assert not is_close(wall)
    assert is_close(wall, now_ns=later_ns)
    assert not is_close(wall, now_ns=later_ns + 1), "too old to brake for"


def test_on_a_bend_what_was_seen_has_moved_round_with_the_vehicle() -> None:
    """Straight ahead when it was seen; after a quarter of a second to the left it lies to the right."""
    later_ns = S_NS + 250_000_000
    bend = a_motion(later_ns, steer_rad=0.4)
    wall = cells((FRONT_M + 2.0, 0.0))
    assert is_close(wall, motion=a_motion(later_ns), now_ns=later_ns)
    assert not is_close(wall, motion=bend, asked=a_command(steer_rad=0.4), now_ns=later_ns)


def test_somebody_who_walks_into_the_way_is_close_and_somebody_who_leaves_it_is_not() -> None:
    assert is_close(a_track(FRONT_M + 1.0, 1.2, vy=-1.5), a_track(FRONT_M + 1.0, 0.3))
    assert is_close(a_track(FRONT_M + 1.0, 0.3))
    assert not is_close(a_track(FRONT_M + 2.0, 0.6, vy=4.0))


def test_a_track_that_moves_is_carried_on_from_when_it_was_seen() -> None:
    later_ns = S_NS + 300_000_000
    crosses = a_track(FRONT_M + 3.0, 0.2, vy=4.0)
    assert not is_close(crosses, now_ns=later_ns)
    assert is_close(a_track(FRONT_M + 2.5, 0.2), now_ns=later_ns)


@pytest.mark.parametrize(("yaw", "met"), [(0.0, False), (math.pi / 2, True)])
def test_a_long_track_reaches_as_far_as_its_outline_in_its_direction(yaw: float, met: bool) -> None:
    beside = a_track(FRONT_M + 1.0, HALF_M + 0.6, kind=CYCLIST, size=(1.8, 0.6), yaw=yaw)
    assert is_close(beside) is met


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_near_side_of_a_wide_track_counts_on_both_sides_of_the_way(side: float) -> None:
    """Its middle is beside the way, its nearer side is in it."""
    reaching = a_track(FRONT_M + 1.0, side * (HALF_M + 0.8), kind=CYCLIST, size=(0.6, 1.8))
    assert is_close(reaching)
    assert not is_close(a_track(FRONT_M + 1.0, side * (HALF_M + 1.0), kind=CYCLIST, size=(0.6, 1.8)))


def test_a_person_is_a_disc_without_corners() -> None:
    radius_m = 0.5
    person = a_track(FRONT_M + 1.0, HALF_M + radius_m - 0.05, size=(2 * radius_m, 2 * radius_m))
    assert is_close(person)
    assert not is_close(a_track(FRONT_M + 1.0, HALF_M + radius_m + 0.05, size=(1.0, 1.0)))
    assert not is_close(a_track(FRONT_M + STOPPING_M + 0.45, HALF_M + 0.4, size=(1.0, 1.0)))


def test_a_person_is_as_wide_as_the_first_of_their_sizes() -> None:
    beside = a_track(FRONT_M + 1.0, HALF_M + 0.45, size=(1.0, 0.2))
    assert is_close(beside)


def test_the_middle_of_an_outline_counts_where_both_its_ends_are_beside_the_way() -> None:
    across = a_track(FRONT_M + 1.0, 0.0, kind=CYCLIST, size=(0.6, 4.0 * HALF_M))
    assert is_close(across)


def test_a_cell_of_somebody_who_leaves_is_theirs_and_one_beside_them_is_not() -> None:
    leaves = a_track(FRONT_M + 2.0, 0.6, vy=4.0)
    assert not is_close(leaves, cells((FRONT_M + 2.0, 0.5)))
    assert is_close(leaves, cells((FRONT_M + 2.0, -0.6)))
    assert is_close(leaves, cells((FRONT_M + 2.0, 0.6 - 0.25 - 0.75)))
    assert not is_close(leaves, cells((FRONT_M + 2.0, 0.6 - 0.25 - 0.65)))


def test_what_stands_beyond_the_end_of_a_long_track_is_not_part_of_it() -> None:
    """A cyclist 2 m long leaves the path in time; a cell 0.9 m ahead of the cyclist is an obstacle."""
    crosses = a_track(FRONT_M + 2.0, -1.2, vy=4.0, kind=CYCLIST, size=(2.0, 0.4), yaw=0.5 * math.pi)
    assert not is_close(crosses, cells((FRONT_M + 2.0, 0.4)))
    assert is_close(crosses, cells((FRONT_M + 2.0, 0.7)))


def test_cells_are_compared_with_where_the_track_was_when_they_were_seen() -> None:
    """The cells are a fifth of a second younger: by then who crosses at 4 m/s is 0.8 m farther."""
    leaves = a_track(FRONT_M + 2.5, 0.0, vy=4.0, stamp_ns=S_NS)
    younger_ns = S_NS + 200_000_000
    theirs = cells((FRONT_M + 2.5, 0.7), stamp_ns=younger_ns)
    not_theirs = cells((FRONT_M + 2.0, -0.4), stamp_ns=younger_ns)
    assert not is_close(leaves, theirs, now_ns=younger_ns)
    assert is_close(leaves, not_theirs, now_ns=younger_ns)


def test_an_older_answer_does_not_replace_a_newer_one() -> None:
    wall, nothing = cells((FRONT_M + 0.5, 0.0)), cells(stamp_ns=S_NS - 1)
    assert is_close(wall, nothing)
    assert not is_close(wall, cells(stamp_ns=S_NS))


# ------------------------------------------------------------ the speed


def test_a_speed_counts_as_impossible_when_two_reports_say_so() -> None:
    limit_mps = (1.0 + SETTINGS.over_share) * SETTINGS.speed_mps_max + SETTINGS.over_mps
    monitor = SpeedMonitor(SETTINGS)
    over, under = limit_mps + 0.01, limit_mps - 0.01
    assert not monitor.is_over(a_motion(1, over))
    assert not monitor.is_over(a_motion(1, over)), "the same report again"
    assert not monitor.is_over(a_motion(2, under))
    assert not monitor.is_over(a_motion(3, over))
    assert monitor.is_over(a_motion(4, over))
    assert not monitor.is_over(a_motion(5, over, enabled=False))


def test_excess_speed_in_the_first_two_reports_is_detected() -> None:
    monitor = SpeedMonitor(SETTINGS)
    over_mps = (1.0 + SETTINGS.over_share) * SETTINGS.speed_mps_max + SETTINGS.over_mps + 0.01
    assert [monitor.is_over(a_motion(stamp_ns, over_mps)) for stamp_ns in (1, 2)] == [False, True]


# ------------------------------------------------------------ the steering


class SteeredWheel:
    """Commands each tick, and a report of the wheel with each; is_stuck is the last answer."""

    def __init__(self) -> None:
        self.monitor = SteeringMonitor(SETTINGS)
        self.now_ns = S_NS
        self.is_stuck = False

    def tick(self, told_rad: float, wheel_rad: float, enabled: bool = True) -> bool:
        self.now_ns += TICK_NS
        self.is_stuck = self.monitor.is_stuck(a_motion(self.now_ns, steer_rad=wheel_rad, enabled=enabled))
        self.monitor.record_sent(self.now_ns, a_command(told_rad, enable=enabled))
        return self.is_stuck

    def hold(self, told_rad: float, wheel_rad: float, ticks: int = 60, enabled: bool = True) -> bool:
        """Whether it was stuck at any moment."""
        answers = [self.tick(told_rad, wheel_rad, enabled) for _ in range(ticks)]
        return True in answers


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_wheel_off_by_more_than_it_may_is_stuck_at_the_second_report(side: float) -> None:
    wheel = SteeredWheel()
    assert not wheel.hold(0.1, 0.1)
    assert not wheel.hold(0.1, 0.1 + side * (SETTINGS.stuck_rad - 0.002))
    assert not wheel.tick(0.1, 0.1 + side * (SETTINGS.stuck_rad + 0.002))
    assert wheel.tick(0.1, 0.1 + side * (SETTINGS.stuck_rad + 0.002))


def test_one_report_that_is_off_is_forgiven() -> None:
    wheel = SteeredWheel()
    wheel.hold(0.1, 0.1)
    for _ in range(5):
        assert not wheel.tick(0.1, 0.3)
        assert not wheel.tick(0.1, 0.1)


def test_before_by_wire_has_had_the_wheel_for_as_long_as_it_takes_to_turn_nothing_is_said() -> None:
    wheel = SteeredWheel()
    ticks = round((SETTINGS.steer_delay_s + SETTINGS.stuck_slack_s) * 1e9) // TICK_NS
    assert not wheel.hold(0.3, 0.0, ticks)
    assert wheel.hold(0.3, 0.0, 60)


def test_by_hand_the_wheel_may_be_anywhere_and_is_judged_anew_afterwards() -> None:
    wheel = SteeredWheel()
    wheel.hold(0.0, 0.0)
    assert not wheel.hold(0.0, 0.4, enabled=False)
    assert not wheel.hold(0.4, 0.4, 10)
    assert not wheel.hold(0.4, 0.4)
    assert wheel.hold(0.4, 0.2)
