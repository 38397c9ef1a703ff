"""Kills and stops real processes in real time: gate and tick of one vehicle.

If the tick is killed, or stopped for a while, the gate must brake. If the gate is killed or stopped, no
process can brake by wire and the profile's fail action applies. After each fault the vehicle must stand until
it is resumed, and then drive again.
"""

import os
import signal
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.reporting.report import Row
from campusloop.live.process_fault_rig import (
    GATE_JOB,
    TICK_JOB,
    BusSample,
    ProcessFaultRig,
    straight_road,
)
from campusloop.scenes.faulted_drive import BRAKES_FROM
from vehicle_agent.config import LidarMount, Profile
from vehicle_agent.signals.rates import TICK_NS

SPEED_MPS = 15.0 / 3.6
BASE_PORT = 52_100
_METRES_A_FAULT = 70.0
_CYCLE = ((TICK_JOB, "SIGKILL"), (TICK_JOB, "SIGSTOP"), (GATE_JOB, "SIGKILL"), (TICK_JOB, "SIGSTOP"))
_CYCLE = (*_CYCLE, (TICK_JOB, "SIGKILL"), (GATE_JOB, "SIGSTOP"))
_READY_S, _STAND_S, _STILL_S = 60.0, 30.0, 2.0
_STANDS_MPS, _MOVES_MPS = 0.02, 0.1
# By-wire must be lost within this time: the live module has a longer timeout (simulator/live/live.py).
_BY_WIRE_LOST_MS = 350.0


class ProcessFaultError(Exception):
    """The vehicle did not start to drive; the message has its processes' logs."""


def process_faults(count: int, profile: Profile, traces: Path | None) -> list[Row]:
    """A row for each signal."""
    limits = msgspec.structs.replace(profile.limits, speed_mps_max=SPEED_MPS)
    # With the spring brake, because a shuttle that coasts without a driver leaves the road.
    profile = msgspec.structs.replace(
        profile, limits=limits, lidar=LidarMount(rate_hz=0.0), perception="own", fail_action="spring_brake"
    )
    road_map = straight_road(200.0 + _METRES_A_FAULT * count, SPEED_MPS)
    rng = np.random.default_rng(count)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        vehicle = ProcessFaultRig(profile, road_map, Path(folder), BASE_PORT)
        vehicle.start()
        try:
            for number in range(count):
                _drive(vehicle, Path(folder))
                rows.append(_fault(vehicle, number, rng, profile, traces))
                print(rows[-1], flush=True)
        finally:
            vehicle.stop()
    return rows


def _drive(vehicle: ProcessFaultRig, folder: Path) -> None:
    """Send the order until the vehicle drives at speed; repeated, because a process may still be starting."""
    deadline_s = time.monotonic() + _READY_S
    while time.monotonic() < deadline_s:
        vehicle.send_order()
        samples = vehicle.listen(9.0, lambda item: item.motion is not None and item.motion.speed_mps > 3.95)
        if samples and samples[-1].motion is not None and samples[-1].motion.speed_mps > 3.95:
            vehicle.listen(0.5)
            return
    logs = "\n".join(f"== {log.name}\n{log.read_text()[-1500:]}" for log in sorted(folder.glob("*.log")))
    raise ProcessFaultError(f"the vehicle does not drive:\n{logs}")


def _fault(
    vehicle: ProcessFaultRig, number: int, rng: np.random.Generator, profile: Profile, traces: Path | None
) -> Row:
    """Send one signal and observe the vehicle until it has stood for a while."""
    process, signal_name = _CYCLE[number % len(_CYCLE)]
    before = vehicle.listen(0.2)
    pid = vehicle.processes.pids[process]
    fault_ns = time.monotonic_ns()
    os.kill(pid, getattr(signal, signal_name))
    samples = list(before)
    if signal_name == "SIGSTOP":
        samples += vehicle.listen(float(rng.uniform(0.3, 1.5)))
        os.kill(pid, signal.SIGCONT)
    samples += vehicle.listen(_STAND_S, lambda item: _stands(item))
    stood = bool(samples) and _stands(samples[-1])
    still = vehicle.listen(_STILL_S + (4.0 if signal_name == "SIGKILL" else 0.0))
    due_ns = _first_missed_ns(samples, fault_ns)
    braked = [
        item.stamp_ns for item in samples if item.brake_ratio >= BRAKES_FROM and item.stamp_ns > fault_ns
    ]
    lost = [
        item.stamp_ns
        for item in samples
        if item.motion is not None and item.stamp_ns > fault_ns and not item.motion.enabled
    ]
    must = "brake" if process == TICK_JOB else "fail action"
    restarts = any(item.motion is not None and item.motion.speed_mps > _MOVES_MPS for item in still)
    latency_ms = (braked[0] - due_ns) / 1e6 if braked else None
    lost_ms = (lost[0] - due_ns) / 1e6 if lost else None
    if traces is not None:
        _write(traces / f"process-{number:03d}.csv", samples + still, fault_ns)
    return {
        "part": "processes",
        "kind": f"{signal_name} {process}",
        "must": must,
        "fail_action": profile.fail_action,
        "latency_ms": latency_ms,
        "stop_m": _distance_m(samples, due_ns) if stood else None,
        "by_wire_lost_ms": lost_ms,
        "restarts": restarts,
        "right": not restarts
        and stood
        and (
            latency_ms is not None if must == "brake" else lost_ms is not None and lost_ms <= _BY_WIRE_LOST_MS
        ),
    }


def _stands(item: BusSample) -> bool:
    return item.motion is not None and abs(item.motion.speed_mps) < _STANDS_MPS


def _first_missed_ns(samples: list[BusSample], fault_ns: int) -> int:
    """When the first missing set was due: a tick after the last one before the fault."""
    sets = [item.stamp_ns for item in samples if item.motion is None and item.stamp_ns <= fault_ns]
    return max(fault_ns, sets[-1] + TICK_NS) if sets else fault_ns


def _distance_m(samples: list[BusSample], from_ns: int) -> float:
    """The distance driven, by the speed reports; each holds until the next."""
    reports = [(item.stamp_ns, item.motion.speed_mps) for item in samples if item.motion is not None]
    distance_m = 0.0
    for (begin_ns, speed_mps), (end_ns, _) in pairwise(reports):
        distance_m += speed_mps * max(0, end_ns - max(begin_ns, from_ns)) * 1e-9
    return distance_m


def _write(path: Path, samples: list[BusSample], fault_ns: int) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = ["t_s,v_mps,by_wire,brake_sent"]
    for item in samples:
        speed = "" if item.motion is None else f"{item.motion.speed_mps:.2f},{int(item.motion.enabled)}"
        brake = f"{item.brake_ratio:.3f}" if item.motion is None else ""
        lines.append(f"{(item.stamp_ns - fault_ns) * 1e-9:.4f},{speed or ','},{brake}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
