"""The Snow Lion stack's control, closed loop: it keeps its path and its times, stops where it shall, and
stands."""

import math
import subprocess
import sys
from pathlib import Path as File
from typing import Any

import msgspec
import numpy as np
import pytest

from benchmarks.tracking.sensing import perfect
from benchmarks.tracking.timed_drive import READY_S, follow_timed
from contract.geometry import Pose2
from contract.runlog.arrays import dec_hook, enc_hook
from simulator.vehicle.plant import PlantParams
from tests.vehicle_agent.control.trajectory.shuttle_drive import (
    HANDS,
    PROFILE,
    HeldByAnother,
    Tampered,
    driven,
    rows_on,
    said,
    straight,
    within_limits,
)
from vehicle_agent.control.trajectory.trajectory_control import TrajectoryControl, TrajectoryControlState
from vehicle_agent.signals import Ego, Path, Trajectory, VehicleMotion

ROOT = File(__file__).resolve().parents[4]
VEHICLES: list[dict[str, Any]] = [
    {},
    {"load_kg": 280.0},
    {"load_kg": -280.0},
    {"grade_ratio": 0.03},
    {"grade_ratio": -0.03},
    {"brake_full_mps2": 4.5},
    {"brake_delay_s": 0.25},
    {"throttle_full_mps2": 2.0},
    {"steer_delay_s": 0.3},
    {"tyres": False},
]


@pytest.mark.parametrize("vehicle", VEHICLES, ids=str)
def test_it_stops_within_five_centimetres_of_the_trajectorys_end(vehicle: dict[str, Any]) -> None:
    rows = rows_on(straight(30.0))
    run = driven(rows, **vehicle)
    assert run.drive.finished
    assert abs(run.drive.trace[-1, 1] - rows[-1, 1]) < 0.05
    assert within_limits(run)


@pytest.mark.parametrize(("speed_mps", "offset_m"), [(4.2, 0.02), (0.3, 0.02)])
def test_it_keeps_a_bend_at_the_fastest_and_at_a_crawl(speed_mps: float, offset_m: float) -> None:
    path = straight(36.0 if speed_mps > 1.0 else 6.0, 30.0)
    run = driven(rows_on(path, speed_mps))
    off_m = np.abs(path.cross_track_m(run.drive.trace[:, 1:3]))
    under_way = path.points[-1, 0] - run.drive.trace[:, 1] > 0.1
    assert run.drive.finished
    assert off_m[under_way].max() < offset_m
    assert run.drive.trace[:, 4].max() == pytest.approx(speed_mps, rel=0.25)


@pytest.mark.parametrize("load_kg", [-280.0, 0.0, 280.0])
def test_it_is_where_the_trajectory_wants_it_when_it_wants_it(load_kg: float) -> None:
    run = driven(rows_on(straight(40.0)), load_kg=load_kg)
    assert np.abs(said(run, "behind_m")[200:]).max() < 0.15


def test_the_steerings_bias_is_found_within_a_few_metres_of_noise() -> None:
    run = driven(rows_on(straight(60.0)))
    bias = said(run, "steer_bias_rad")
    far = run.drive.trace[:, 1] > 8.0
    assert np.abs(bias[far] - math.radians(0.6)).max() < math.radians(0.15)
    assert bias[-1] == pytest.approx(math.radians(0.6), abs=math.radians(0.05))


def test_noise_does_not_shake_the_wheel() -> None:
    run = driven(rows_on(straight(60.0)))
    steer = np.array([command.steer_rad for command in run.commands])
    steady = (run.drive.trace[:, 1] > 20.0) & (run.drive.trace[:, 1] < 50.0)
    assert np.abs(np.diff(steer[steady]) / 0.02).max() < math.radians(2.0)
    assert steer[steady].std() < math.radians(0.2)


def test_a_standing_vehicle_holds_still() -> None:
    run = driven(rows_on(straight(20.0)), settle_s=12.0)
    last = slice(-500, None)
    steer = np.array([command.steer_rad for command in run.commands])[last]
    brake = np.array([command.brake_ratio for command in run.commands])[last]
    assert np.ptp(steer) == 0.0
    assert np.ptp(run.drive.trace[last, 1]) == 0.0
    assert all(command.throttle_ratio == 0.0 for command in run.commands[last])
    assert brake.min() > 0.4


def test_it_starts_again_without_a_leap_and_brakes_without_a_jolt() -> None:
    first, second = rows_on(straight(20.0)), rows_on(straight(20.0))
    second[:, 0] += first[-1, 0] + 5.0
    second[:, [1, 7]] += 20.0
    run = driven(np.vstack((first, second)))
    accel = run.drive.trace[:, 5]
    jerk = (accel[5:] - accel[:-5]) / 0.1
    assert run.drive.finished
    assert accel.max() < 1.1
    assert accel.min() > -0.8
    assert np.percentile(np.abs(jerk), 99.0) < 1.93
    assert np.abs(jerk).max() < 3.5
    stood = (run.drive.trace[:, 0] > first[-1, 0] + 1.0) & (run.drive.trace[:, 0] < second[0, 0] - 0.5)
    assert np.all(run.drive.trace[stood, 4] == 0.0)


@pytest.mark.parametrize("load_kg", [-280.0, 280.0])
@pytest.mark.parametrize("throttle_full_mps2", [1.9, 3.1])
@pytest.mark.parametrize("brake_full_mps2", [4.5, 6.7])
def test_after_the_first_start_it_sets_off_as_planned(
    load_kg: float, throttle_full_mps2: float, brake_full_mps2: float
) -> None:
    """Whatever its drive and brake are: who creeps beside people must not leap."""
    one = rows_on(straight(8.0), 1.0)
    rows = []
    for k in range(4):
        again = one.copy()
        again[:, 0] += k * (one[-1, 0] + 3.0)
        again[:, [1, 7]] += k * 8.0
        rows.append(again)
    plan = np.vstack(rows)
    run = driven(
        plan, load_kg=load_kg, throttle_full_mps2=throttle_full_mps2, brake_full_mps2=brake_full_mps2
    )
    trace = run.drive.trace
    faster_mps = trace[:, 4] - np.interp(trace[:, 0], plan[:, 0], plan[:, 5])
    assert run.drive.finished
    assert faster_mps[trace[:, 0] > plan[len(one), 0]].max() < 0.08


def test_pedals_do_not_dance() -> None:
    run = driven(rows_on(straight(60.0)))
    pedals = np.sign([command.throttle_ratio - command.brake_ratio for command in run.commands])
    changes = np.count_nonzero(np.diff(pedals[pedals != 0.0]))
    assert changes <= 4


def test_waypoints_are_followed_where_there_are_no_times() -> None:
    path = straight(40.0, 25.0)
    way = path.points[::50]

    def waypoints(tick: int, ego: Ego, given: Path) -> tuple[Ego, Path]:
        heading = np.array((math.cos(ego.pose_map.yaw_rad), math.sin(ego.pose_map.yaw_rad)))
        ahead = (way - np.array((ego.pose_map.x_m, ego.pose_map.y_m))) @ heading > 0.0
        speeds = np.full(int(ahead.sum()), 2.0)
        speeds[-1:] = 0.0
        return ego, Path(ego.stamp_ns, way[ahead], speeds, 2.0, "cap", None, 40.0, False)

    run = driven(rows_on(path, 2.0), waypoints)
    off_m = np.abs(path.cross_track_m(run.drive.trace[:, 1:3]))
    assert off_m.max() < 0.15
    assert run.drive.trace[:, 4].max() == pytest.approx(2.0, abs=0.25)
    assert math.hypot(*(run.drive.trace[-1, 1:3] - path.points[-1])) < 1.2


def test_an_emergency_brakes_as_hard_as_the_vehicle_can() -> None:
    def emergency(tick: int, ego: Ego, path: Path) -> tuple[Ego, Path]:
        return ego, msgspec.structs.replace(path, emergency=tick > 500)

    run = driven(rows_on(straight(60.0)), emergency)
    after = run.commands[501:]
    assert all(command.brake_ratio == 1.0 and command.throttle_ratio == 0.0 for command in after)
    assert run.drive.trace[600, 4] == 0.0


def the_way_on(tick: int) -> tuple[Ego, Path, VehicleMotion]:
    """Inputs of a drive that nobody simulates: enough to make every part of the state move."""
    now_ns = (tick + 1) * 20_000_000
    rows = rows_on(straight(30.0))
    wave = 0.02 * math.sin(0.7 * tick)
    ego = Ego(now_ns, Pose2(0.03 * tick, wave, 0.1 * wave), 1.5, 0.0, wave, 0.0, 0.02, now_ns, True)
    motion = VehicleMotion(now_ns, 1.5, 0.01, 0.0, 0.0, True, False, True, 1.0)
    path = Path(now_ns, rows[:, 1:3], rows[:, 5], 3.0, "plan", None, 0.0, False, 0.0, Trajectory(1, rows))
    return ego, path, motion


def wished(
    state: TrajectoryControlState, first: int, last: int
) -> tuple[list[bytes], TrajectoryControlState]:
    encoder = msgspec.msgpack.Encoder(enc_hook=enc_hook)
    told = []
    for tick in range(first, last):
        command, state = HANDS.step(state, *the_way_on(tick))
        told.append(encoder.encode(command))
    return told, state


def test_what_is_remembered_survives_another_process_bit_for_bit(tmp_path: File) -> None:
    _, middle = wished(HANDS.initial(), 0, 60)
    expected, _ = wished(middle, 60, 120)
    assert middle.bounded > 0
    file = tmp_path / "state"
    file.write_bytes(msgspec.msgpack.encode(middle, enc_hook=enc_hook))
    script = (
        "import sys; from tests.vehicle_agent.control.trajectory import test_trajectory_control as t; "
        "told, _ = t.wished(t.remembered(sys.argv[1]), 60, 120); "
        "sys.stdout.write(b''.join(told).hex())"
    )
    there = subprocess.run(
        [sys.executable, "-c", script, str(file)], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert there.stdout == b"".join(expected).hex()


def remembered(file: str) -> TrajectoryControlState:
    return msgspec.msgpack.decode(File(file).read_bytes(), type=TrajectoryControlState, dec_hook=dec_hook)


def test_a_vehicle_that_others_held_for_a_minute_starts_like_any_other() -> None:
    rows = rows_on(straight(30.0))

    def leaving(
        brake_ratio: float, ticks: int, state: TrajectoryControlState
    ) -> tuple[list[float], TrajectoryControlState]:
        told = []
        for tick in range(ticks):
            now_ns = (tick + 1) * 20_000_000
            ego = Ego(now_ns, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, now_ns, True)
            motion = VehicleMotion(now_ns, 0.0, 0.0, 0.0, brake_ratio, True, False, True, 1.0)
            path = Path(
                now_ns, rows[:, 1:3], rows[:, 5], 3.0, "plan", None, 0.0, False, 0.0,
                Trajectory(now_ns - 1_000_000_000, rows),
            )  # fmt: skip
            command, state = HANDS.step(state, ego, path, motion)
            told.append(command.throttle_ratio)
        return told, state

    held, state = leaving(1.0, 3000, HANDS.initial())
    after, _ = leaving(0.0, 10, state)
    fresh, _ = leaving(0.0, 10, HANDS.initial())
    assert max(held[10:]) < 0.15
    assert after[0] <= fresh[0] + 0.05


def test_tampering_with_nothing_changes_nothing() -> None:
    hands = Tampered(HANDS, lambda tick, ego, path: (ego, path))
    _, direct = HANDS.step(HANDS.initial(), *the_way_on(0))
    _, (_, through) = hands.step(hands.initial(), *the_way_on(0))
    assert msgspec.msgpack.encode(direct, enc_hook=enc_hook) == msgspec.msgpack.encode(
        through, enc_hook=enc_hook
    )


@pytest.mark.parametrize("disturbance_mps2", [-0.3, 0.0, 0.21, 0.6])
def test_a_vehicle_that_the_guard_holds_for_want_of_throttle_sets_off(disturbance_mps2: float) -> None:
    """It rolls better than expected, as was learned on the way; at rest that must not keep the throttle shut.

    The guard holds a vehicle that stands without throttle, and control begins anew while it is held.
    """
    rows = rows_on(straight(20.0), 2.0)
    state = HANDS.initial()
    pedals = state.estimate.pedals
    learned = msgspec.structs.replace(pedals, mean=np.array((disturbance_mps2, 1.0, 1.0)))
    estimate = msgspec.structs.replace(state.estimate, pedals=learned)
    state = msgspec.structs.replace(state, estimate=estimate)
    throttles = []
    for tick in range(1, 60):
        now_ns = tick * 20_000_000
        ego = Ego(now_ns, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, now_ns, True)
        path = Path(now_ns, rows[:, 1:3], rows[:, 5], 2.0, "speed_limit", None, 20.0, False, 0.6)
        path = msgspec.structs.replace(path, trajectory=Trajectory(20_000_000, rows))
        motion = VehicleMotion(now_ns, 0.0, 0.0, 0.0, 0.5, True, False, True, 1.0)
        command, state = HANDS.step(state, ego, path, motion)
        throttles.append(command.throttle_ratio)
    assert max(throttles[30:]) > 0.0


def after_release(control: TrajectoryControl, grade_ratio: float) -> tuple[list[float], list[float]]:
    """(places ahead, accelerations) in the two seconds after another brake let the vehicle go.

    The trajectory began a second before, so that the vehicle is late and control would like to hurry.
    """
    tick_s = 0.02
    released = round((READY_S + 1.0) / tick_s)
    held = HeldByAnother(control, released)
    plant = PlantParams(grade_ratio=grade_ratio)
    run = follow_timed(rows_on(straight(30.0), 2.0), PROFILE, held, plant, perfect)
    after = run.drive.trace[released : released + round(2.0 / tick_s)]
    return after[:, 1].tolist(), after[:, 5].tolist()


def without_set_off(control: TrajectoryControl) -> TrajectoryControl:
    return msgspec.structs.replace(control, speed=msgspec.structs.replace(control.speed, set_off_mps2=0.0))


def test_it_sets_off_gently_while_the_report_of_the_released_brake_is_under_way() -> None:
    """The report is a dead time old; a vehicle that waited for it would be later, and no smoother."""
    places_m, accels_mps2 = after_release(HANDS, 0.0)
    waiting_m, waiting_mps2 = after_release(without_set_off(HANDS), 0.0)
    assert places_m[50] > waiting_m[50] + 0.01
    assert max(np.diff(accels_mps2)) < max(np.diff(waiting_mps2)) + 0.02


@pytest.mark.parametrize(("grade_ratio", "back_m"), [(0.02, 1e-6), (0.04, 0.035)])
def test_it_rolls_back_no_more_than_a_vehicle_that_waits_for_the_report(
    grade_ratio: float, back_m: float
) -> None:
    """The slope is unknown, since the vehicle has not moved yet. Simulated sites slope by 2 % at the most."""
    places_m, _ = after_release(HANDS, grade_ratio)
    waiting_m, _ = after_release(without_set_off(HANDS), grade_ratio)
    assert min(places_m) >= min(waiting_m)
    assert min(places_m) > places_m[0] - back_m


def test_a_vehicle_that_is_to_stand_gets_no_throttle_while_another_brake_holds_it() -> None:
    state, now_ns = HANDS.initial(), 0
    for tick in range(1, 200):
        now_ns = tick * 20_000_000
        ego = Ego(now_ns, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, now_ns, True)
        motion = VehicleMotion(now_ns, 0.0, 0.0, 0.0, 0.5 if tick < 100 else 0.9, True, False, True, 1.0)
        path = Path(now_ns, np.zeros((0, 2)), np.zeros(0), 0.0, "obstacle", None, 0.0, False)
        command, state = HANDS.step(state, ego, path, motion)
        assert command.throttle_ratio == 0.0
