"""The guard, as a table: what is wrong, and what it does about it."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2
from contract.wire.messages import Blocked, FaultRaised, ModeChanged
from vehicle_agent.config import Profile
from vehicle_agent.guard.guard import GuardState
from vehicle_agent.signals import (
    GATE_BRAKING,
    NO_TRACKS,
    PEDESTRIAN,
    Actuation,
    Ages,
    ControlCommand,
    Ego,
    Fault,
    GuardStatus,
    Path,
    Task,
    Tracks,
    VehicleMotion,
    World,
)
from vehicle_agent.stacks.rooms import guard

GUARD = guard(Profile())
TICK_NS = 20_000_000
FRESH = Ages(0, 0, 0, 0)
CRUISE = ControlCommand(0.0, 0.3, 0.0, 0.1)


class Bench:
    """A guard and its last state; every input has a healthy default."""

    def __init__(self) -> None:
        self.state = GUARD.initial()
        self.now_ns = 0
        self.events: list[Any] = []

    def step(
        self,
        wish: ControlCommand = CRUISE,
        ages: Ages = FRESH,
        points: tuple[tuple[float, float], ...] = (),
        blind: bool = False,
        tracks: Tracks = NO_TRACKS,
        **changes: Any,
    ) -> tuple[Actuation, GuardStatus]:
        self.now_ns += changes.pop("tick_ns", TICK_NS)
        ego = Ego(self.now_ns, Pose2(0, 0, 0), 2.0, 0.0, 0.0, 0.0, 0.02, self.now_ns, True)
        motion = VehicleMotion(self.now_ns, 2.0, 0.0, 0.0, 0.0, True, False, True, 0.9)
        task = Task(
            "drive", None, 1, 0.0, 0.0, 50.0, "l", 0.0, "o", 1, "v", "", "", False, (), "", None, resumed_ns=1
        )
        path = Path(self.now_ns, np.empty((0, 2)), np.empty(0), 2.0, "waypoint_speed", None, 50.0, False)
        values = {"ego": ego, "motion": motion, "task": task, "path": path}
        for name, value in changes.items():
            kind, _, field = name.partition("_")
            values[kind] = msgspec.structs.replace(values[kind], **{field: value})
        world = World(self.now_ns, self.now_ns, np.array(points).reshape(-1, 2), (), (), blind, tracks)
        act, verdict, self.state = GUARD.step(
            self.state, wish, values["motion"], values["ego"], world, values["task"], values["path"], ages
        )
        self.events += GUARD.events(self.state)
        return act, verdict


def driving() -> Bench:
    bench = Bench()
    for _ in range(3):
        act, verdict = bench.step()
    assert (act.enable, act.throttle_ratio, verdict.mode) == (True, 0.3, "autonomous")
    return bench


CAUSES: dict[str, dict[str, Any]] = {
    "motion_stale": {"ages": Ages(160_000_000, 0, 0, 0)},
    "pose_stale": {"ages": Ages(0, 310_000_000, 0, 0)},
    "percept_stale": {"ages": Ages(0, 0, 410_000_000, 0)},
    "percept_missing": {"ages": Ages(0, 0, -1, 0)},
    "path_stale": {"ages": Ages(0, 0, 0, 210_000_000)},
    "lidar_blind": {"blind": True},
    "command_not_finite": {"wish": ControlCommand(math.nan, 0.3, 0.0, 0.0)},
    "pose_jump": {"ego_faults": (Fault("pose_jump", "stop", 5),)},
    "emergency_stop_pressed": {"motion_faults": (Fault("emergency_stop_pressed", "stop", 5),)},
    "tick_lost": {"tick_ns": 600_000_000},
}


@pytest.mark.parametrize("code", CAUSES)
def test_a_stop_fault_brakes_latches_and_waits_for_a_resume_after_the_cause(code: str) -> None:
    bench = driving()
    act, verdict = bench.step(**CAUSES[code])
    assert verdict.mode == "minimal_risk"
    assert code in [fault.code for fault in verdict.faults]
    firm = code in ("motion_stale", "emergency_stop_pressed", "tick_lost")
    assert (act.throttle_ratio, act.brake_ratio) == (0.0, GUARD.firm_ratio if firm else GUARD.stop_ratio)
    act, verdict = bench.step()
    assert (verdict.mode, act.throttle_ratio) == ("minimal_risk", 0.0), "the cause is gone, the latch is not"
    again = {**CAUSES[code], "task_resumed_ns": bench.now_ns}
    if code != "tick_lost":
        assert bench.step(**again)[1].mode == "minimal_risk", (
            "a resume does not help while the cause is there"
        )
    act, verdict = bench.step(task_resumed_ns=bench.now_ns + 1)
    assert (verdict.mode, act.throttle_ratio) == ("autonomous", 0.3)


def test_after_a_start_the_shuttle_reports_once_that_it_is_held_and_why() -> None:
    """The server may still take it for driving: the tick was started again under way."""
    bench = Bench()
    waiting = {"task_mode": "hold", "task_resumed_ns": 0, "task_hold_reason": "just_started"}
    for _ in range(3):
        _, status = bench.step(**waiting)
    assert (status.mode, status.reason) == ("held", "just_started")
    changes = [event for event in bench.events if isinstance(event, ModeChanged)]
    assert changes == [ModeChanged("held", "just_started")]


def test_an_operators_hold_names_their_own_text_and_another_text_is_another_report() -> None:
    bench = driving()
    bench.events.clear()
    for text in ("fire drill", "fire drill", "over soon"):
        bench.step(task_mode="hold", task_hold_reason="operator_hold", task_hold_detail=text)
    changes = [event for event in bench.events if isinstance(event, ModeChanged)]
    assert changes == [ModeChanged("held", "operator_hold", text) for text in ("fire drill", "over soon")]


def test_a_stop_for_faults_names_all_that_hold_the_shuttle() -> None:
    bench = driving()
    bench.events.clear()
    bench.step(blind=True, ages=Ages(0, 310_000_000, 0, 0))
    (change,) = [event for event in bench.events if isinstance(event, ModeChanged)]
    assert (change.mode, change.reason) == ("minimal_risk", "fault")
    assert set(change.faults) == {"lidar_blind", "pose_stale"}


def test_a_warning_of_the_same_code_does_not_hide_a_fault_that_stops() -> None:
    """Localization warns of single fixes that are no numbers; a pose that is none stops the shuttle."""
    bench = driving()
    warning = Fault("pose_not_finite", "warning", 5)
    assert bench.step(ego_faults=(warning,))[1].mode == "autonomous"
    _, status = bench.step(ego_faults=(warning,), ego_pose_map=Pose2(math.nan, 0.0, 0.0))
    assert status.mode == "minimal_risk"
    assert ("pose_not_finite", "stop") in [(fault.code, fault.severity) for fault in status.faults]


def test_a_fault_is_reported_when_raised_and_when_cleared() -> None:
    bench = driving()
    bench.events.clear()
    for _ in range(5):
        bench.step(blind=True)
    for _ in range(5):
        bench.step()
    told = [event for event in bench.events if isinstance(event, FaultRaised)]
    assert [(event.fault.code, event.cleared) for event in told] == [
        ("lidar_blind", False),
        ("lidar_blind", True),
    ]


def test_two_faults_never_cancel() -> None:
    bench = driving()
    act, verdict = bench.step(blind=True, path_emergency=True, wish=ControlCommand(0.0, 1.0, 0.1, 0.0))
    assert (act.throttle_ratio, act.brake_ratio) == (0.0, 1.0)
    assert verdict.mode == "minimal_risk"


def test_a_warning_does_not_stop_the_vehicle() -> None:
    act, verdict = driving().step(tick_ns=70_000_000)
    assert verdict.mode == "autonomous"
    assert [fault.code for fault in verdict.faults] == ["tick_late"]
    assert act.throttle_ratio == 0.3


@pytest.mark.parametrize(
    ("wheels_mps", "estimated_mps", "held"), [(0.0, 0.0, True), (0.0, 2.0, False), (2.0, 0.0, False)]
)
def test_the_brake_holds_a_shuttle_only_if_both_its_speeds_say_that_it_stands(
    wheels_mps: float, estimated_mps: float, held: bool
) -> None:
    bench = driving()
    coast = ControlCommand(0.0, 0.0, 0.0, 0.0)
    act, _ = bench.step(coast, motion_speed_mps=wheels_mps, ego_speed_mps=estimated_mps)
    assert (act.brake_ratio > 0.0) == held


def test_an_override_is_a_takeover_until_the_next_resume() -> None:
    bench = driving()
    act, verdict = bench.step(motion_overridden=True)
    assert (act.enable, verdict.mode) == (False, "manual")
    assert (act.gear, act.throttle_ratio, act.brake_ratio) == ("neutral", 0.0, 0.0)
    for _ in range(10):
        act, verdict = bench.step(motion_enabled=False)
        assert (act.enable, verdict.mode) == (False, "manual")
    assert any(
        isinstance(e, ModeChanged) and e.mode == "manual" and "takeover" in e.reason for e in bench.events
    )
    resumed_ns = bench.now_ns
    act, verdict = bench.step(motion_enabled=False, motion_overridden=True, task_resumed_ns=resumed_ns)
    assert (act.enable, act.throttle_ratio, act.brake_ratio) == (True, 0.0, 0.0)
    act, verdict = bench.step(task_resumed_ns=resumed_ns)
    assert (act.throttle_ratio, verdict.mode) == (0.3, "autonomous")


def test_a_driver_who_takes_over_right_after_a_resume_has_the_vehicle_at_once() -> None:
    bench = driving()
    bench.step(task_resumed_ns=2)
    act, verdict = bench.step(motion_enabled=False, motion_overridden=True, task_resumed_ns=2)
    assert (act.enable, verdict.mode) == (False, "manual")


def test_a_driver_who_keeps_overriding_keeps_the_vehicle() -> None:
    bench = driving()
    bench.step(motion_overridden=True)
    resumed_ns = bench.now_ns
    for _ in range(150):
        _, verdict = bench.step(motion_enabled=False, motion_overridden=True, task_resumed_ns=resumed_ns)
    assert verdict.mode == "manual"


def test_by_wire_that_is_not_enabled_in_time_is_a_fault() -> None:
    bench = driving()
    for _ in range(150):
        _act, verdict = bench.step(motion_enabled=False)
    assert verdict.mode == "fault"
    assert "by_wire_not_given" in [fault.code for fault in verdict.faults]


def test_by_wire_is_given_two_seconds_and_not_a_tick_more() -> None:
    bench = driving()
    waited = [bench.step(motion_enabled=False)[1].faults for _ in range(150)]
    first = next(ticks for ticks, faults in enumerate(waited) if faults)
    assert (waited[first][0].code, first * TICK_NS) == ("by_wire_not_given", 2_000_000_000)


def test_after_boot_nothing_is_enabled_before_the_first_resume() -> None:
    act, verdict = Bench().step(task_mode="hold", task_resumed_ns=0)
    assert (act.enable, act.gear, verdict.mode) == (False, "park", "held")


def test_a_held_vehicle_stands_on_its_brake() -> None:
    bench = driving()
    act, verdict = bench.step(task_mode="hold", ego_speed_mps=0.0, motion_speed_mps=0.0)
    assert (act.throttle_ratio, act.brake_ratio, verdict.mode) == (0.0, GUARD.hold_ratio, "held")


def test_the_guard_brakes_for_an_obstacle_within_braking_distance_whatever_planning_says() -> None:
    act, verdict = driving().step(points=((4.5, 0.2),))
    assert (act.brake_ratio, act.throttle_ratio, verdict.intervened) == (1.0, 0.0, "obstacle")
    act, verdict = driving().step(points=((4.5, 1.4), (20.0, 0.0), (1.0, 0.9)))
    assert verdict.intervened == ""


def test_overspeed_is_braked() -> None:
    act, verdict = driving().step(ego_speed_mps=4.5)
    assert (act.brake_ratio, verdict.intervened) == (GUARD.stop_ratio, "overspeed")


@given(st.lists(st.tuples(*[st.floats(-10.0, 10.0)] * 3, st.booleans(), st.booleans()), max_size=30))
def test_every_command_is_within_limits(ticks: list[tuple[float, float, float, bool, bool]]) -> None:
    bench, steer = Bench(), 0.0
    for wished, throttle, brake, enabled, emergency in ticks:
        act, _ = bench.step(
            ControlCommand(wished, throttle, brake, 0.0), motion_enabled=enabled, path_emergency=emergency
        )
        assert 0.0 <= act.throttle_ratio <= GUARD.limits.throttle_ratio_max
        assert 0.0 <= act.brake_ratio <= 1.0
        assert act.throttle_ratio == 0.0 or act.brake_ratio == 0.0
        assert abs(act.steer_rad) <= GUARD.limits.steer_rad_max
        if enabled:
            assert abs(act.steer_rad - steer) <= GUARD.limits.steer_rate_radps_max * 0.02 + 1e-9
        steer = act.steer_rad


def test_a_minute_behind_an_obstacle_is_reported_once_and_its_end_once() -> None:
    bench = driving()
    standing = {
        "ego_speed_mps": 0.0,
        "motion_speed_mps": 0.0,
        "path_limited_by": "obstacle",
        "path_obstacle_m": 4.0,
    }
    for _ in range(61 * 50):
        bench.step(**standing)
    for _ in range(10):
        bench.step()
    blocked = [event for event in bench.events if isinstance(event, Blocked)]
    assert [event.cleared for event in blocked] == [False, True]
    assert blocked[0].obstacle_m == 4.0


def test_the_gate_s_own_braking_latches_until_a_resume_requests_by_wire_again() -> None:
    gate_brakes = {"motion_faults": (Fault(f"{GATE_BRAKING}_tick_late", "stop", 5),)}
    bench = driving()
    assert bench.step(**gate_brakes)[1].mode == "minimal_risk"
    assert bench.step()[1].mode == "minimal_risk"
    resumed = {"task_resumed_ns": bench.now_ns + 1}
    act, _ = bench.step(**gate_brakes, **resumed)
    assert act.enable is False, "enable falls for one tick"
    act, verdict = bench.step(**gate_brakes, **resumed)
    assert (act.enable, verdict.mode) == (True, "autonomous"), "and is asked for again"
    for _ in range(150):
        _, verdict = bench.step(**gate_brakes, **resumed)
    assert verdict.mode == "minimal_risk", "a gate that does not let go is a fault after all"


def test_a_clock_that_goes_back_stops_the_vehicle() -> None:
    bench = driving()
    _, verdict = bench.step(tick_ns=-10_000_000)
    assert verdict.mode == "minimal_risk"
    assert "clock_went_back" in [fault.code for fault in verdict.faults]


def test_while_the_clock_goes_back_the_wheels_stay_as_they_are() -> None:
    bench = driving()
    turned_rad = bench.step(wish=ControlCommand(0.4, 0.3, 0.0, 0.1))[0].steer_rad
    act, _ = bench.step(wish=ControlCommand(-0.4, 0.0, 0.0, 0.1), tick_ns=-10_000_000)
    assert turned_rad > 0.0
    assert act.steer_rad == turned_rad


def test_a_position_that_is_not_finite_stops_the_vehicle() -> None:
    _, verdict = driving().step(ego_pose_map=Pose2(math.nan, 0.0, 0.0))
    assert (verdict.mode, verdict.faults[0].code) == ("minimal_risk", "pose_not_finite")


def test_a_poor_position_lowers_the_speed_limit_gently_to_half_a_metre_per_second() -> None:
    bench = driving()
    pedals = []
    for _ in range(200):
        act, verdict = bench.step(ego_position_std_m=0.5)
        pedals.append(act.brake_ratio)
    assert pedals[0] == 0.0, "not at once"
    assert pedals[-1] == GUARD.slow_ratio < GUARD.stop_ratio
    assert verdict.intervened == "overspeed"
    slow = {"ego_speed_mps": 0.4, "motion_speed_mps": 0.4, "ego_position_std_m": 0.5}
    assert bench.step(**slow)[0].throttle_ratio == 0.3
    assert bench.step()[0].throttle_ratio == 0.3, "a good position gives the speed back"


@pytest.mark.parametrize("mode", ["idle", "dwell", "hold"])
def test_throttle_is_ignored_without_a_task_to_drive(mode: str) -> None:
    act, _ = driving().step(task_mode=mode, ego_speed_mps=0.0, motion_speed_mps=0.0)
    assert (act.throttle_ratio, act.brake_ratio) == (0.0, GUARD.hold_ratio)


def test_a_vehicle_with_open_doors_stands() -> None:
    act, _ = driving().step(task_doors_open=True, ego_speed_mps=0.0, motion_speed_mps=0.0)
    assert (act.throttle_ratio, act.brake_ratio) == (0.0, GUARD.hold_ratio)


def test_a_standing_vehicle_does_not_roll() -> None:
    bench = driving()
    still = {"ego_speed_mps": 0.02, "motion_speed_mps": 0.02}
    assert bench.step(wish=ControlCommand(0.0, 0.0, 0.0, 0.0), **still)[0].brake_ratio == GUARD.hold_ratio
    back = {"ego_speed_mps": -0.3, "motion_speed_mps": -0.3}
    assert bench.step(**back)[0].brake_ratio == GUARD.stop_ratio


def test_tracks_that_are_not_finite_raise_a_fault_and_slow_the_vehicle() -> None:
    bench = driving()
    act, verdict = bench.step(tracks=someone(math.nan, 0.0))
    assert (act.throttle_ratio, act.brake_ratio) == (0.0, GUARD.slow_ratio)
    assert [fault.code for fault in verdict.faults] == ["tracks_not_finite"]
    assert bench.step()[0].throttle_ratio == 0.3, "and when they are numbers again it goes on"


def test_a_person_within_the_footprint_s_margin_keeps_the_vehicle_from_setting_off() -> None:
    still = {"ego_speed_mps": 0.0, "motion_speed_mps": 0.0}
    for x, y in ((3.9, 0.0), (1.0, 1.05), (3.3, 1.1), (2.0, 0.0)):
        act, verdict = driving().step(tracks=someone(x, y), **still)
        assert (act.throttle_ratio, act.brake_ratio) == (0.0, GUARD.hold_ratio), (x, y)
        assert verdict.intervened == "somebody close"
    for x, y in ((1.0, 1.6), (1.0, 1.1)):
        act, _ = driving().step(tracks=someone(x, y), **still)
        assert act.throttle_ratio == 0.3, (x, y)


def test_a_person_who_steps_in_front_of_a_creeping_bumper_stops_the_vehicle() -> None:
    creeping = {"ego_speed_mps": 0.1, "motion_speed_mps": 0.1}
    for x, y in ((4.03, 0.0), (3.6, 1.1)):
        act, verdict = driving().step(tracks=someone(x, y), **creeping)
        assert (act.throttle_ratio, act.brake_ratio) == (0.0, GUARD.hold_ratio), (x, y)
        assert verdict.intervened == "somebody close"
    for x, y in ((4.4, 0.0), (3.6, 1.4), (2.5, 1.1)):
        assert driving().step(tracks=someone(x, y), **creeping)[0].throttle_ratio == 0.3, (x, y)


def test_the_guard_s_state_survives_encoding_and_decoding() -> None:
    bench = driving()
    bench.step(blind=True, tracks=someone(6.0, 0.0))
    again = msgspec.msgpack.decode(msgspec.msgpack.encode(bench.state), type=GuardState)
    assert again == bench.state


def someone(x_m: float, y_m: float) -> Tracks:
    return Tracks(
        1,
        np.array([7]),
        np.array([PEDESTRIAN]),
        np.array([[x_m, y_m, 0.0]]),
        np.zeros((1, 2)),
        np.full((1, 2), 0.5),
    )


def test_a_new_guard_is_held() -> None:
    assert GuardState().mode == "held"


def test_the_steering_follows_a_command_at_the_rate_of_the_steering_also_after_a_long_tick() -> None:
    bench, rate = driving(), GUARD.limits.steer_rate_radps_max
    turning = ControlCommand(0.4, 0.3, 0.0, 0.1)
    assert bench.step(wish=turning)[0].steer_rad == pytest.approx(rate * 0.02)
    assert bench.step(wish=turning, tick_ns=40_000_000)[0].steer_rad == pytest.approx(rate * 0.06)
    assert bench.step(wish=turning, tick_ns=400_000_000)[0].steer_rad == pytest.approx(rate * 0.16)


def test_the_brake_for_a_person_is_not_lessened_while_they_are_in_danger() -> None:
    """One estimate says that less would do, the next that it does not: that costs the brake's lag twice."""
    bench, front_m = driving(), Profile().body.front_overhang_m

    def pedal(ahead_m: float) -> float:
        tracks = msgspec.structs.replace(someone(front_m + ahead_m, 0.0), stamp_ns=bench.now_ns + TICK_NS)
        return bench.step(tracks=tracks, ego_speed_mps=0.8, motion_speed_mps=0.8)[0].brake_ratio

    first = pedal(0.84)
    assert 0.0 < first < 1.0
    assert pedal(0.6) == 1.0
    assert pedal(0.84) == 1.0
    assert pedal(12.0) == 0.0
    assert pedal(0.84) == first


def beside(gap_m: float, walks_mps: float = 1.2) -> Tracks:
    """Somebody who walks along the middle of the vehicle."""
    y_m = 0.5 * Profile().body.width_m + 0.25 + gap_m
    return Tracks(
        0,
        np.array([1]),
        np.array([PEDESTRIAN]),
        np.array([[1.0, y_m, 0.0]]),
        np.array([[walks_mps, 0.0]]),
        np.array([[0.5, 0.5]]),
    )


def beside_at(gap_m: float, speed_mps: float) -> tuple[Actuation, GuardStatus]:
    bench = driving()
    tracks = msgspec.structs.replace(beside(gap_m), stamp_ns=bench.now_ns + TICK_NS)
    return bench.step(tracks=tracks, ego_speed_mps=speed_mps, motion_speed_mps=speed_mps)


@pytest.mark.parametrize(
    ("gap_m", "speed_mps", "brakes"),
    [(0.05, 3.0, True), (0.05, 1.5, False), (0.05, 1.0, False), (0.3, 3.0, False), (0.5, 3.0, False)],
)
def test_people_at_the_flank_are_passed_slowly(gap_m: float, speed_mps: float, brakes: bool) -> None:
    act, verdict = beside_at(gap_m, speed_mps)
    assert (act.brake_ratio > 0.0) is brakes
    assert verdict.intervened == ("somebody alongside" if brakes else "")
    assert act.brake_ratio <= GUARD.slow_ratio, "nobody inside falls"


def test_people_who_walk_along_all_the_time_slow_the_vehicle_and_never_stop_it() -> None:
    """A crowd that keeps to its side for a minute: it ends at a walk, not at a stand."""
    bench, speed_mps = driving(), 3.0
    for _ in range(3000):
        tracks = msgspec.structs.replace(beside(0.02, speed_mps), stamp_ns=bench.now_ns + TICK_NS)
        act, _ = bench.step(tracks=tracks, ego_speed_mps=speed_mps, motion_speed_mps=speed_mps)
        accel_mps2 = -2.0 * act.brake_ratio if act.brake_ratio > 0.0 else 0.5
        speed_mps = max(0.0, speed_mps + 0.02 * accel_mps2)
    assert 0.9 < speed_mps < 1.6


LOST = {"ego_phase": "lost", "ego_valid": False, "ego_faults": (Fault("pose_poor", "stop", 5),)}
OTHERS = ("lidar_blind", "motion_stale", "command_not_finite", "emergency_stop_pressed", "percept_stale")


def lost_and_stopped() -> Bench:
    bench = driving()
    for _ in range(3):
        assert bench.step(**LOST)[1].mode == "minimal_risk"
    return bench


def test_a_vehicle_whose_place_is_proven_drives_on_without_a_resume() -> None:
    bench = lost_and_stopped()
    assert bench.step(ego_phase="tracking")[1].mode == "minimal_risk", "found again, and not proven"
    act, verdict = bench.step(ego_phase="tracking", ego_proven_ns=bench.now_ns)
    assert (verdict.mode, verdict.faults) == ("autonomous", ())
    assert act.throttle_ratio == CRUISE.throttle_ratio
    assert [event.mode for event in bench.events if isinstance(event, ModeChanged)][-2:] == [
        "minimal_risk",
        "autonomous",
    ]


def test_a_proof_of_an_earlier_loss_ends_no_later_one() -> None:
    bench = lost_and_stopped()
    proven_ns = bench.now_ns
    bench.step(ego_phase="tracking", ego_proven_ns=proven_ns)
    bench.step(**LOST, ego_proven_ns=proven_ns)
    assert bench.step(ego_phase="tracking", ego_proven_ns=proven_ns)[1].mode == "minimal_risk"


@pytest.mark.parametrize("code", OTHERS)
def test_a_proof_ends_no_stop_for_anything_else(code: str) -> None:
    bench = lost_and_stopped()
    bench.step(**{**LOST, **CAUSES[code]} if "ego_faults" not in CAUSES[code] else CAUSES[code])
    for _ in range(5):
        _, verdict = bench.step(ego_phase="tracking", ego_proven_ns=bench.now_ns)
        assert verdict.mode == "minimal_risk"


def test_a_vehicle_with_open_doors_stays_where_it_is_though_its_place_is_proven() -> None:
    bench = lost_and_stopped()
    standing = {"ego_speed_mps": 0.0, "motion_speed_mps": 0.0, "task_doors_open": True}
    bench.step(ego_phase="tracking", **standing)
    act, verdict = bench.step(ego_phase="tracking", ego_proven_ns=bench.now_ns, **standing)
    assert verdict.mode == "autonomous"
    assert (act.throttle_ratio, act.brake_ratio) == (0.0, GUARD.hold_ratio)


poses = st.sampled_from(("tracking", "doubtful", "lost", "recovered", "gnss_only"))


@given(st.lists(st.tuples(poses, st.booleans(), st.sampled_from((None, None, None, *OTHERS))), max_size=60))
def test_a_stop_ends_by_itself_only_after_a_loss_that_is_proven_and_nothing_else(
    ticks: list[tuple[str, bool, str | None]],
) -> None:
    """A vehicle that drives on without a resume was lost, has been proven since, and has no other fault."""
    bench = driving()
    proven_ns, lost_ns, other, stopped = 0, 0, False, False
    for phase, is_proven, code in ticks:
        now_ns = bench.now_ns + TICK_NS
        proven_ns = now_ns if is_proven and phase == "tracking" else proven_ns
        changes: dict[str, Any] = dict(LOST) if phase == "lost" else {"ego_phase": phase}
        if code is not None:
            changes |= CAUSES[code]
            other = True
        lost_ns = now_ns if phase == "lost" else lost_ns
        _, verdict = bench.step(ego_proven_ns=proven_ns, **changes)
        is_stop = verdict.mode in ("minimal_risk", "fault")
        assert not (phase == "lost" or code is not None) or is_stop
        if stopped and not is_stop:
            assert 0 < lost_ns < proven_ns
            assert not other
            lost_ns = 0
        stopped = is_stop
