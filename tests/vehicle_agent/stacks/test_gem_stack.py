"""The whole tick on the simulated vehicle: a ride over CAN, with lidar; state saved and restored mid-way."""

import functools
import math
import sys

import msgspec
import pytest
from numba.core.registry import CPUDispatcher

from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.runlog.arrays import enc_hook
from contract.wire.messages import FaultRaised, RiderAlighted, RiderBoarded, VisitChanged
from simulator.ecus.safety_driver import SafetyDriver
from simulator.riders import Rider
from simulator.world import WorldOptions
from tests.vehicle_agent.driven_shuttle import DrivenShuttle, rider
from tests.vehicle_agent.mission.ring import ring
from vehicle_agent.config import Driving, Profile
from vehicle_agent.onboard.state import OnboardState
from vehicle_agent.runtime.recording.snapshot import decode_state, encode_state
from vehicle_agent.signals import FleetVehicle, LidarCondition, LidarConditions
from vehicle_agent.stacks import warm

_encoder = msgspec.msgpack.Encoder(enc_hook=enc_hook)
START, ON, OFF = ("south", 5.0), ("south", 40.0), ("north", 30.0)


@functools.cache
def the_ring() -> RoadMap:
    return ring()


def a_shuttle(profile: Profile | None = None, **options: object) -> DrivenShuttle:
    settings = WorldOptions(traffic=None, **options)  # type: ignore[arg-type]
    shuttle = DrivenShuttle(the_ring(), START, profile or Profile(), settings)
    visits = (
        shuttle.visit("on", *ON, START, board=(rider("ann", 1, "1111"),), dwell_s=8.0),
        shuttle.visit("off", *OFF, ON, alight=(rider("ann", 1, "1111"),), dwell_s=8.0),
        shuttle.visit("rest", "north", 70.0, OFF, kind="rest", dwell_s=0.0),
    )
    shuttle.say(shuttle.order_for(visits, START))
    shuttle.run(1.0)
    shuttle.resume()
    return shuttle


def finished(shuttle: DrivenShuttle) -> bool:
    return not shuttle.state.mission.memory.open_visits()


@pytest.mark.long
def test_a_ride_is_driven_from_stop_to_stop_within_twenty_centimetres() -> None:
    shuttle = a_shuttle()
    stops = [Pose2(*shuttle.network.pose(*place)) for place in (ON, OFF)]
    shuttle.world.riders.add(Rider("ann", "1111", 1, "code", stops[0], stops[1]))
    errors = []
    known = 0
    for _ in range(200 * 50):
        shuttle.step()
        for _, event in shuttle.events[known:]:
            if isinstance(event, VisitChanged) and event.state == "under_way":
                state = shuttle.state.mission
                errors.append(abs(state.s_m - state.route.visit_s(event.visit_id)))
        known = len(shuttle.events)
        if finished(shuttle):
            break
    assert finished(shuttle)
    events = [event for _, event in shuttle.events]
    assert RiderBoarded("ann", "code") in events
    assert any(isinstance(event, RiderAlighted) for event in events)
    assert max(errors) < 0.2
    score = shuttle.world.score("s1")
    assert score.hardest_braking_mps2 < 1.5
    assert score.speed_mps_max < 3.2
    assert shuttle.outputs is not None
    assert shuttle.outputs.report.faults == ()


def test_a_state_saved_mid_way_and_restored_gives_identical_outputs() -> None:
    kept, restored = a_shuttle(), a_shuttle()
    for k in range(30 * 50):
        assert _encoder.encode(kept.step()) == _encoder.encode(restored.step())
        if k % 250 == 100:
            restored.state = decode_state(encode_state(restored.state), restored.car)
    assert kept.world.truth("s1") == restored.world.truth("s1")


def test_the_takeover_of_the_safety_driver_ends_autonomy_at_once() -> None:
    shuttle = a_shuttle()
    shuttle.run(8)
    shuttle.world.module("s1").driver = SafetyDriver(brake_ratio=0.3)
    shuttle.run(0.5)
    assert shuttle.outputs is not None
    assert shuttle.outputs.report.mode == "manual"


def test_a_silent_receiver_slows_the_vehicle_and_at_last_ends_in_a_minimal_risk_stop() -> None:
    """Odometry knows the place well for the next tens of metres, less well then, and not for ever."""
    shuttle = a_shuttle()
    shuttle.run(8)
    shuttle.world.gnss["s1"].silent = True
    assert shuttle.run(60, lambda s: s.state.localization.since_fix_m > 20.0)
    assert shuttle.outputs is not None
    assert shuttle.outputs.report.mode == "autonomous"
    assert shuttle.run(120, lambda s: s.outputs is not None and s.outputs.flow.ego.position_std_m > 0.32)
    shuttle.run(4)
    assert shuttle.world.truth("s1").speed_mps < 0.6
    assert error_m(shuttle) < 2.5 * shuttle.outputs.flow.ego.position_std_m
    shuttle.state = lost(shuttle)
    shuttle.run(4)
    assert shuttle.outputs.report.mode == "minimal_risk"
    assert shuttle.world.truth("s1").speed_mps == 0.0
    assert "pose_stale" in [fault.code for fault in shuttle.outputs.report.faults]
    shuttle.world.gnss["s1"].silent = False
    shuttle.run(3)
    assert shuttle.world.truth("s1").speed_mps == 0.0
    shuttle.resume()
    shuttle.run(6)
    assert shuttle.world.truth("s1").speed_mps > 1.0


def error_m(shuttle: DrivenShuttle) -> float:
    assert shuttle.outputs is not None
    here, truth = shuttle.outputs.flow.ego.pose_map, shuttle.world.truth("s1").pose_map
    return math.hypot(here.x_m - truth.x_m, here.y_m - truth.y_m)


def lost(shuttle: DrivenShuttle) -> OnboardState:
    """As after 200 m without a fix, which this ring is too short for."""
    localization = msgspec.structs.replace(shuttle.state.localization, since_fix_m=201.0)
    return msgspec.structs.replace(shuttle.state, localization=localization)


@pytest.mark.parametrize("aside_m", [-2.2, 1.5, 2.2])
@pytest.mark.parametrize("s_m", [40.0, 72.0])
def test_a_shuttle_beside_its_lane_comes_back_without_crossing_it(s_m: float, aside_m: float) -> None:
    """On a straight, and with a bend just ahead: where an operator resumes it after it was pushed aside."""
    start = ("south", s_m)
    shuttle = DrivenShuttle(the_ring(), start, Profile(), WorldOptions(traffic=None), aside_m=aside_m)
    shuttle.say(
        shuttle.order_for((shuttle.visit("rest", "north", 30.0, start, kind="rest", dwell_s=0.0),), start)
    )
    shuttle.run(1.0)
    shuttle.resume()
    across_m = 0.0
    for _ in range(20 * 50):
        shuttle.step()
        assert shuttle.outputs is not None
        across_m = max(across_m, -math.copysign(1.0, aside_m) * shuttle.outputs.flow.task.d_m)
    assert shuttle.outputs.report.mode == "autonomous"
    assert abs(shuttle.outputs.flow.task.d_m) < 0.15
    assert across_m < 0.3


@pytest.mark.parametrize("obstacles", ["line", "paper"])
def test_either_obstacle_rule_reaches_the_stop_on_an_empty_road(obstacles: str) -> None:
    shuttle = a_shuttle(Profile(driving=Driving(obstacles=obstacles)))  # type: ignore[arg-type]
    assert shuttle.run(60, lambda s: s.state.mission.memory.under_way == "on")


def test_a_moved_lidar_is_named_in_status_and_event_and_the_shuttle_drives_on() -> None:
    shuttle = a_shuttle()
    shuttle.run(10)
    moved = (LidarCondition("front_left", "moved"),)
    shuttle.say(LidarConditions(shuttle.now_ns, moved))
    shuttle.run(1)
    assert shuttle.outputs is not None
    faults = [(fault.code, fault.detail) for fault in shuttle.outputs.report.faults]
    assert faults == [("lidar_moved", "front_left")]
    assert shuttle.outputs.report.mode == "autonomous"
    # The memory of it is part of the state from which a segment is replayed.
    restored = decode_state(encode_state(shuttle.state), shuttle.car)
    assert _encoder.encode(restored) == _encoder.encode(shuttle.state)
    shuttle.say(LidarConditions(shuttle.now_ns))
    shuttle.run(1)
    assert shuttle.outputs.report.faults == ()
    told = [event for _, event in shuttle.events if isinstance(event, FaultRaised)]
    assert [(event.fault.detail, event.cleared) for event in told] == [
        ("front_left", False), ("front_left", True),
    ]  # fmt: skip


def test_warm_kernels_leave_nothing_to_compile_for_a_drive() -> None:
    warm.warm_kernels()
    before = _specialisations()
    shuttle = a_shuttle()
    shuttle.run(15)
    grown = {name for name, count in _specialisations().items() if count > before.get(name, 0)}
    assert grown == set()


def _specialisations() -> dict[str, int]:
    found: dict[str, int] = {}
    for name, module in sorted(sys.modules.items()):
        if name.startswith(("vehicle_agent", "contract")) and module is not None:
            for attribute, value in sorted(vars(module).items()):
                if isinstance(value, CPUDispatcher):
                    found[f"{name}.{attribute}"] = len(value.signatures)
    return found


def test_the_shuttle_stops_behind_a_fleet_mate_with_a_gap_between_the_bumpers() -> None:
    shuttle = a_shuttle()
    x_m, y_m, yaw_rad = shuttle.network.pose("south", 30.0)
    for _ in range(25 * 50):
        shuttle.say(FleetVehicle(shuttle.now_ns, "mate", Pose2(x_m, y_m, yaw_rad), 0.0))
        shuttle.step()
    gap_m = x_m - 0.85 - (shuttle.world.truth("s1").pose_map.x_m + 3.5)
    assert shuttle.world.truth("s1").speed_mps < 0.1
    assert 4.0 < gap_m < 7.0
