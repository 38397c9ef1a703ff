"""The obstacle rule, the selector, the approach and the gap, by their exact figures."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2
from tests.vehicle_agent.planning.builders import ROOM, a_line
from vehicle_agent.config import Driving, Profile
from vehicle_agent.planning.waypoint.approach import Approach
from vehicle_agent.planning.waypoint.obstacle import sweep_arc, sweep_line
from vehicle_agent.planning.waypoint.selector import SpeedCommand, lowest
from vehicle_agent.planning.waypoint.waypoints import WaypointRules, curve_speed_mps, waypoints_from_line
from vehicle_agent.signals import FleetVehicle
from vehicle_agent.stacks.rooms import waypoint_planning

RULE = ROOM.obstacle
LINE = a_line()


@pytest.mark.parametrize(
    ("distance_m", "speed_mps"), [(4.99, 0.0), (5.0, 0.0), (7.5, 0.5), (10.0, 1.0), (15.0, 2.0), (20.0, 3.0)]
)
def test_the_obstacle_rule_is_a_fifth_of_the_distance_less_one(distance_m: float, speed_mps: float) -> None:
    assert RULE.allowed_mps(distance_m) == pytest.approx(speed_mps)


def test_within_five_metres_the_command_is_an_emergency() -> None:
    near, far = RULE.command(4.9), RULE.command(5.1)
    assert near is not None
    assert near.emergency
    assert near.speed_mps == 0.0
    assert far is not None
    assert not far.emergency
    assert RULE.command(math.inf) is None


def test_the_path_is_checked_to_where_the_rule_reaches_the_speed() -> None:
    assert RULE.check_m(3.0) == 20.0
    assert RULE.check_m(5.0) == 30.0
    paper = waypoint_planning(Profile(driving=Driving(obstacles="paper"))).obstacle
    assert (paper.check_m(3.0), paper.along) == (15.0, "arc")


@pytest.mark.parametrize("ahead_m", [0.7, 5.0, 12.3, 19.0])
def test_distance_is_what_the_bumper_has_still_to_go(ahead_m: float) -> None:
    sweep = sweep_line(LINE.points, LINE.s, 20.0, 0.0, 20.0)
    points = np.array([[20.0 + 3.5 + ahead_m, 0.3]])
    assert RULE.free_m(points, sweep, 0.4) == pytest.approx(ahead_m, abs=1e-9)


def test_what_stands_beside_the_widened_path_does_not_count() -> None:
    sweep = sweep_line(LINE.points, LINE.s, 20.0, 0.0, 20.0)
    assert math.isinf(RULE.free_m(np.array([[30.0, 0.815 + 0.41]]), sweep, 0.4))
    assert math.isfinite(RULE.free_m(np.array([[30.0, 0.815 + 0.39]]), sweep, 0.4))


def test_somebody_alongside_does_not_hold_a_vehicle_that_drives_straight() -> None:
    sweep = sweep_line(LINE.points, LINE.s, 20.0, 0.0, 20.0)
    assert math.isinf(RULE.free_m(np.array([[21.0, 0.815 + 0.3]]), sweep, 0.4))


def test_somebody_beside_the_nose_counts_when_the_nose_swings_there() -> None:
    person = np.array([[4.6, 1.4]])
    straight = sweep_arc(Pose2(0.0, 0.0, 0.0), 0.0, 2.6, 4.0)
    turning = sweep_arc(Pose2(0.0, 0.0, 0.0), 0.45, 2.6, 4.0)
    assert math.isinf(RULE.free_m(person, straight, 0.15))
    assert RULE.free_m(person, turning, 0.15) < 2.0


@given(st.lists(st.floats(0.0, 5.0), min_size=1, max_size=6))
def test_the_lowest_command_wins_and_names_itself(speeds: list[float]) -> None:
    commands = [SpeedCommand(f"c{i}", speed) for i, speed in enumerate(speeds)]
    chosen = lowest(commands)
    assert chosen.speed_mps == min(speeds)
    assert chosen.name == f"c{speeds.index(min(speeds))}"


def test_of_equal_commands_an_emergency_wins() -> None:
    assert lowest([SpeedCommand("stop", 0.0), SpeedCommand("obstacle", 0.0, emergency=True)]).emergency


def test_an_approach_is_a_comfortable_deceleration_to_the_stop() -> None:
    approach = Approach(decel_mps2=0.6, delay_s=0.0, ramp_s=0.0)
    assert approach.command(7.5, 3.0).speed_mps == pytest.approx(3.0)
    assert approach.command(7.5, 3.0).accel_mps2 == pytest.approx(-0.6)
    assert approach.command(50.0, 3.0).accel_mps2 == 0.0
    assert approach.command(0.0, 0.0).speed_mps == 0.0


def test_a_stop_that_comes_late_is_braked_for_harder_but_within_bounds() -> None:
    late = Approach().command(1.5, 3.0)
    assert late.accel_mps2 == -Approach().decel_mps2_firm
    assert Approach().command(-2.0, 3.0).accel_mps2 == -Approach().decel_mps2_firm


def test_the_gap_is_between_bumpers_and_leaves_five_metres() -> None:
    mate = FleetVehicle(1, "b", Pose2(20.0 + 3.5 + 9.0 + 0.85, 0.2, 0.0), 0.0)
    lead = ROOM.gap.lead(LINE.points, LINE.s, 20.0, 19, (mate,))
    assert lead is not None
    assert lead.gap_m == pytest.approx(9.0)
    command = ROOM.gap.command(lead)
    assert command is not None
    assert command.speed_mps == pytest.approx(2.0)


@pytest.mark.parametrize("pose", [Pose2(10.0, 0.0, 0.0), Pose2(40.0, 3.0, 0.0), Pose2(90.0, 0.0, 0.0)])
def test_a_mate_behind_beside_or_far_ahead_is_no_lead(pose: Pose2) -> None:
    assert ROOM.gap.lead(LINE.points, LINE.s, 20.0, 19, (FleetVehicle(1, "b", pose, 0.0),)) is None


def test_a_mate_that_stands_across_the_line_is_a_lead_though_its_rear_axle_is_beside_it() -> None:
    mate = FleetVehicle(1, "b", Pose2(35.0, -3.0, 0.5 * math.pi), 0.0)
    lead = ROOM.gap.lead(LINE.points, LINE.s, 20.0, 19, (mate,))
    assert lead is not None
    assert 10.0 < lead.gap_m < 11.5


def test_curve_speed_is_the_root_of_half_the_radius() -> None:
    assert curve_speed_mps(18.0) == pytest.approx(3.0)
    assert curve_speed_mps(8.0) == pytest.approx(2.0)


def test_waypoints_are_a_metre_apart_and_go_beyond_the_end() -> None:
    waypoints = waypoints_from_line(LINE, WaypointRules(3.0))
    assert np.allclose(np.hypot(*np.diff(waypoints.points_map, axis=0).T), 1.0)
    assert waypoints.s_m[-1] == pytest.approx(108.0)
    assert np.allclose(waypoints.speeds_mps, 3.0)
