"""The GEM stack's control as a whole: what it gives from one tick to the next."""

from pathlib import Path as File

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.config import load_profile
from vehicle_agent.control.waypoint.waypoint_control import WaypointControlState
from vehicle_agent.signals import ControlCommand, Ego, Path, VehicleMotion
from vehicle_agent.stacks.rooms import waypoint_control

PROFILE = File(__file__).resolve().parents[4] / "vehicle_agent" / "profiles" / "campus-shuttle.toml"
HANDS = waypoint_control(load_profile(PROFILE))


def standing(
    brake_ratio: float, ticks: int, hands: WaypointControlState
) -> tuple[list[ControlCommand], WaypointControlState]:
    """A free road at 3 m/s ahead of a vehicle that does not move."""
    points = np.column_stack((np.arange(1.0, 40.0), np.zeros(39)))
    path = Path(1, points, np.full(39, 3.0), 3.0, "cap", None, 40.0, False, 0.0)
    ego = Ego(1, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, 1, True)
    motion = VehicleMotion(1, 0.0, 0.0, 0.0, brake_ratio, True, False, True, 1.0)
    wishes = []
    for _ in range(ticks):
        command, hands = HANDS.step(hands, ego, path, motion)
        wishes.append(command)
    return wishes, hands


def test_a_vehicle_that_was_held_for_a_minute_starts_like_any_other() -> None:
    _, held = standing(1.0, 3000, HANDS.initial())
    after, _ = standing(0.0, 50, held)
    fresh, _ = standing(0.0, 50, HANDS.initial())
    # One step of the minute is the first step of the start.
    assert [command.throttle_ratio for command in after[:-1]] == [
        command.throttle_ratio for command in fresh[1:]
    ]
    assert after[0].throttle_ratio < 0.02


def test_no_throttle_is_given_against_a_brake() -> None:
    wishes, _ = standing(0.8, 500, HANDS.initial())
    assert max(command.throttle_ratio for command in wishes) < 0.05
