"""One injection in virtual time: drive, inject the fault, and measure the reaction."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.drive_by_wire.faults import FaultKind
from benchmarks.reporting.report import Row
from campusloop.scenes.faulted_drive import (
    BRAKES_FROM,
    STEP_NS,
    VEHICLE_ID,
    Course,
    FaultedDrive,
)
from simulator.vehicle.plant import PlantParams, plant_params

STEP_MS = STEP_NS / 1e6
TRACE_COLUMNS = ("injection", "t_s", "way_m", "v_mps", "steer_rad", "brake_sent", "by_wire")
# A stuck wheel cannot be detected before its angle error is this large, about three degrees.
STUCK_DETECTABLE_RAD = 0.05
_STANDS_MPS = 0.01
_OBSERVE_S = 8.0
_STANDS_S = 1.0
_MOVED_M = 0.02
_GOES_ON_S = 1.5
# The operator resumes after a while, when the console shows no more stop faults.
_OPERATOR_STEPS, _FAULTS_OVER_STEPS_MAX = 25, 250
_STUCK, _REPORTS_LOST = "steering stuck", "reports lost"


@dataclass(slots=True)
class InjectionResult:
    """The result of an injection. latency_ms, stop_m: None without a brake, or without a stop."""

    latency_ms: float | None = None
    stop_m: float | None = None
    moved_again_m: float = 0.0
    by_wire_ms: float | None = None
    throttle_after: bool = False
    trace: list[tuple[float, ...]] = field(default_factory=list)


def inject(course: Course, kind: FaultKind, number: int, seed: int) -> tuple[Row, InjectionResult]:
    """Run one injection. Returns its row of the report and the result."""
    rng = np.random.default_rng([seed, number])
    drive = FaultedDrive(course, int(rng.integers(2**31)))
    drive.set_off()
    for _ in range(int(rng.integers(25, 100))):
        drive.step()
    speed_mps = drive.world.truth(VEHICLE_ID).speed_mps
    after = kind.inject(drive, rng)
    result = _observe(drive, kind, after, number)
    row: Row = {
        "injection": number,
        "kind": kind.name,
        "must": kind.must,
        "fail_action": course.profile.fail_action,
        "speed_mps": speed_mps,
        "latency_ms": result.latency_ms,
        "stop_m": result.stop_m,
        "moved_again_m": result.moved_again_m,
        "by_wire_lost_ms": result.by_wire_ms,
        "gate": drive.wired.gate.braking,
        "guard": drive.computer.state.guard.reason,
        "crash": "; ".join(drive.crashes),
        "right": _is_right(kind, course, result),
        "restarts": result.moved_again_m > _MOVED_M,
        "released": _released(drive) if kind.must == "brake" and number % 11 == 0 else None,
    }
    return row, result


class FaultFreeSteering:
    """The angle of a fault-free steering for the given commands, with dead time and lag."""

    def __init__(self, steer_rad: float, params: PlantParams) -> None:
        self.steer_rad = steer_rad
        delay_steps = round(params.steer_delay_s * 1e9 / STEP_NS)
        self._retained = math.exp(-STEP_NS * 1e-9 / params.steer_lag_s)
        self._delayed = deque([steer_rad] * delay_steps)

    def step(self, commanded_rad: float) -> float:
        self._delayed.append(commanded_rad)
        target = self._delayed.popleft()
        self.steer_rad = target + (self.steer_rad - target) * self._retained
        return self.steer_rad


def _observe(
    drive: FaultedDrive, kind: FaultKind, after: Callable[[int], None], number: int
) -> InjectionResult:
    """Step until the vehicle has stood for a while, or has driven on long enough."""
    out = InjectionResult()
    truth = drive.world.truth(VEHICLE_ID)
    begin_m, stood_m, still = truth.odometer_m, -1.0, 0
    # The step of the first missing frame, or of the first detectable angle error.
    fault_step = -1
    column = FaultFreeSteering(truth.steer_rad, plant_params(drive.course.profile))
    for step in range(round(_OBSERVE_S * 1e9 / STEP_NS)):
        drive.step()
        after(step)
        truth = drive.world.truth(VEHICLE_ID)
        if fault_step < 0:
            astray_rad = abs(column.step(drive.computer.state.guard.steer_rad) - truth.steer_rad)
            seen = astray_rad > STUCK_DETECTABLE_RAD if kind.name == _STUCK else _is_seen(drive, kind)
            # A brake before the fault is detectable by this rule has no latency.
            if seen or drive.brake_ratio >= BRAKES_FROM:
                fault_step, begin_m = step, truth.odometer_m
        if out.latency_ms is None and fault_step >= 0 and drive.brake_ratio >= BRAKES_FROM:
            out.latency_ms = (step - fault_step) * STEP_MS
        by_wire = drive.world.module(VEHICLE_ID).enabled
        if out.by_wire_ms is None and not by_wire:
            out.by_wire_ms = (step + 1) * STEP_MS
        out.throttle_after = out.throttle_after or (out.by_wire_ms is not None and truth.throttle_ratio > 0.3)
        if stood_m < 0.0 and truth.speed_mps < _STANDS_MPS:
            stood_m = truth.odometer_m
            out.stop_m = stood_m - begin_m
        if stood_m >= 0.0:
            out.moved_again_m = truth.odometer_m - stood_m
            still += 1
        way_m, by_wire_share = truth.odometer_m - begin_m, float(by_wire)
        seen_now = (truth.speed_mps, truth.steer_rad, drive.brake_ratio, by_wire_share)
        out.trace.append((number, step * STEP_NS * 1e-9, way_m, *seen_now))
        undisturbed = kind.must in ("go on", "either") and out.latency_ms is None
        if still * STEP_MS >= 1e3 * _STANDS_S or (undisturbed and step * STEP_MS >= 1e3 * _GOES_ON_S):
            break
    return out


def _is_seen(drive: FaultedDrive, kind: FaultKind) -> bool:
    """A report was changed in this step; reports come only at 30 Hz."""
    if kind.name != _REPORTS_LOST:
        return True
    return drive.world.bus_faults(VEHICLE_ID).changed_to_vehicle > 0


def _is_right(kind: FaultKind, course: Course, seen: InjectionResult) -> bool:
    """The vehicle has reacted as required. The summary checks latency and distance over all injections."""
    still = seen.moved_again_m <= _MOVED_M
    if kind.must == "brake":
        return seen.latency_ms is not None and seen.stop_m is not None and still
    if kind.must == "go on":
        return seen.latency_ms is None and seen.by_wire_ms is None
    if kind.must == "either":
        return seen.stop_m is None or still
    lets_go = seen.by_wire_ms is not None and seen.by_wire_ms <= 140.0 and not seen.throttle_after
    if course.profile.fail_action == "spring_brake":
        return lets_go and seen.stop_m is not None and still
    return lets_go and still


def _released(drive: FaultedDrive) -> bool:
    """The vehicle drives again after the fault is over and an operator has resumed it."""
    drive.set_filter = lambda sets: sets
    drive.world.module(VEHICLE_ID).steering_stuck = False
    if drive.tick_jump_ns != drive.gate_jump_ns:
        # A tick whose clock differs from the gate's must be restarted.
        drive.tick_jump_ns = drive.gate_jump_ns
        drive.boot_tick()
    for step in range(_FAULTS_OVER_STEPS_MAX):
        drive.step()
        faults = drive.computer.state.guard.faults
        if step >= _OPERATOR_STEPS and not any(fault.severity == "stop" for fault in faults):
            break
    stood_m = drive.world.truth(VEHICLE_ID).odometer_m
    drive.resume()
    for _ in range(200):
        drive.step()
    return drive.world.truth(VEHICLE_ID).odometer_m - stood_m > 0.5
