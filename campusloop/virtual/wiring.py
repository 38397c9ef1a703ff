"""A vehicle's computer and gate wired to the simulated vehicle: 20 ms from the bus to the bus.

The module's reports -> gate -> inbox -> tick -> gate -> the bus. The workers' results for a scan and the
planner's answer to a job arrive after the time that they would take. The composition of a drive puts the rest
into the inbox: messages of a link, an operator or cameras.
"""

import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np

from campusloop.virtual.conductor import STEP_NS
from campusloop.virtual.wired_perception import WiredPerception
from contract.roads.model import RoadMap
from contract.runlog.matched_scans import MatchedScan
from simulator.world import SimWorld
from vehicle_agent.can.by_wire import braking_of
from vehicle_agent.config import Profile
from vehicle_agent.gate.gate import Gate, gate_of
from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.runtime.code_mask import CodeMask
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.inbox import Inbox
from vehicle_agent.runtime.processes.maps.localization_process import MATCHED_SOURCE
from vehicle_agent.runtime.processes.sensing.worker_process import THINNED_SOURCE
from vehicle_agent.signals import (
    CanFrame,
    InboxBody,
    LocalizationJob,
    ObstaclePercept,
    Outputs,
    PlanAnswer,
    PlanJob,
    ScanAnswer,
    ThinnedScan,
    TrackPercept,
)
from vehicle_agent.signals.objects import EgoMotion
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud
from vehicle_agent.stacks.choice import (
    Planner,
    build_localization_worker,
    build_planner,
)

# The motion planner's time for one job, with the transport there and back.
PLAN_DELAY_NS = 2 * STEP_NS
# The localization worker's time for one scan, and for one while the vehicle is lost, with the transport there
# and back. Scans that come meanwhile are skipped.
LOCALIZATION_DELAY_NS = 4 * STEP_NS
SEARCH_DELAY_NS = 20 * STEP_NS

# Changes a value on its way from a device or worker; None: the value is lost.
InputFilter = Callable[[InboxBody], InboxBody | None]


def unchanged(body: InboxBody) -> InboxBody | None:
    return body


class WiredGate:
    """The gate process between the simulated bus and the tick's inbox; either can be restarted."""

    def __init__(
        self, vehicle_id: str, profile: Profile, world: SimWorld, mask: CodeMask | None = None
    ) -> None:
        self._vehicle_id, self._profile, self._world, self._mask = vehicle_id, profile, world, mask
        self._gap_ns = braking_of(profile).frame_gap_ns
        self.restart_gate()
        self.restart_inbox()

    def restart_gate(self) -> None:
        """A new gate process, in its initial state."""
        self.gate = gate_of(self._profile)

    def restart_inbox(self) -> None:
        """For a new tick process; the old one's messages are lost."""
        self.inbox = Inbox(mask=self._mask)

    def take_reports(self, reports: tuple[CanFrame, ...], now_ns: int) -> None:
        """Take the module's reports at now_ns of the gate's clock, and forward them to the tick."""
        stamped = tuple(msgspec.structs.replace(frame, stamp_ns=now_ns) for frame in reports)
        self.gate.take_reports(stamped, now_ns)
        self._forward_to_tick(stamped, now_ns)

    def send(self, now_ns: int, bus_ns: int) -> tuple[CanFrame, ...]:
        """Step the gate at now_ns of its clock; the frames that it passes are on the bus at bus_ns."""
        sent = self.gate.step(now_ns)
        self._forward_to_tick(self.gate.report_frames(now_ns), now_ns)
        on_bus = (
            CanFrame(bus_ns + k * self._gap_ns, frame.arbitration_id, frame.data)
            for k, frame in enumerate(sent)
        )
        self._world.frames_from_vehicle(self._vehicle_id, tuple(on_bus))
        return sent

    def _forward_to_tick(self, frames: tuple[CanFrame, ...], now_ns: int) -> None:
        for frame in frames:
            self.inbox.put(now_ns, "can", frame)


class WiredLocalization:
    """The localization worker beside the tick: scans and jobs in, answers when they are due.

    cpu_ms  of each scan so far
    """

    def __init__(self, worker: LocalizationWorker) -> None:
        self._worker = worker
        self._scan: PointCloud | None = None
        self._due: deque[tuple[int, ScanAnswer | MatchedScan]] = deque()
        self._busy_until_ns = 0
        self.cpu_ms: list[float] = []

    def see(self, points_base: np.ndarray, stamp_ns: int) -> None:
        self._scan = point_cloud(stamp_ns, points_base)

    def due(self, now_ns: int) -> list[ScanAnswer | MatchedScan]:
        """The answers that have arrived, and scans for the run log."""
        found = []
        while self._due and self._due[0][0] <= now_ns:
            found.append(self._due.popleft()[1])
        return found

    def step(self, jobs: tuple[LocalizationJob, ...], now_ns: int) -> None:
        """Take a tick's jobs, and work on the newest scan if the last one is done."""
        for job in jobs:
            self._worker.take(job)
        scan = self._scan
        if scan is None or now_ns < self._busy_until_ns or not self._worker.is_ready(scan.stamp_ns):
            return
        self._scan = None
        begun_s = time.process_time()
        answer = self._worker.answer(scan)
        self.cpu_ms.append(1e3 * (time.process_time() - begun_s))
        self._busy_until_ns = now_ns + (
            SEARCH_DELAY_NS if jobs and jobs[-1].is_lost else LOCALIZATION_DELAY_NS
        )
        if answer is not None:
            self._due.append((self._busy_until_ns, answer))
            matched = self._worker.take_matched()
            if matched is not None:
                self._due.append((self._busy_until_ns, matched))


class WiredVehicle:
    """Call `boot` with a computer, then `step` repeatedly; `crash` ends the computer.

    mask         masks boarding codes; None for a drive without riders
    computer     None while there is none
    planner      answers the jobs of a stack that makes any
    sent_frames  that the gate passed in the last step
    tick_wall_ns, tick_cpu_s  the last tick's times
    plan_cpu_ms  CPU of each motion plan so far
    localization  the worker of a vehicle with a point map
    """

    def __init__(
        self,
        vehicle_id: str,
        profile: Profile,
        road_map: RoadMap,
        world: SimWorld,
        mask: CodeMask | None = None,
        point_map: Path | None = None,
    ) -> None:
        """point_map: the folder of the map that scans are compared with. Raises PointMapError."""
        self._vehicle_id, self._world = vehicle_id, world
        self._profile, self._point_map = profile, point_map
        self._bus = WiredGate(vehicle_id, profile, world, mask)
        self._perception = WiredPerception(vehicle_id, profile, world)
        self.planner: Planner | None = build_planner(profile, road_map)
        self._plans: deque[tuple[int, PlanAnswer]] = deque()
        self.localization: WiredLocalization | None = self._new_localization()
        self.computer: VehicleComputer | None = None
        self.tick_wall_ns, self.tick_cpu_s = 0, 0.0
        self.plan_cpu_ms: list[float] = []
        self.sent_frames = 0

    @property
    def percept_cpu_ms(self) -> list[float]:
        """CPU of the percepts of each scan of this boot so far."""
        return self._perception.cpu_ms

    @property
    def gate(self) -> Gate:
        """The gate of this boot."""
        return self._bus.gate

    @property
    def inbox(self) -> Inbox:
        """The inbox of this boot."""
        return self._bus.inbox

    def boot(self, computer: VehicleComputer) -> None:
        """Start everything onboard in its initial state, except the computer."""
        self._bus.restart_gate()
        self._bus.restart_inbox()
        self.localization = self._new_localization()
        self._perception = WiredPerception(self._vehicle_id, self._profile, self._world)
        self.computer = computer

    def crash(self) -> None:
        """End everything onboard at once."""
        self.computer = None
        self._perception.crash()
        self._plans.clear()

    def _new_localization(self) -> WiredLocalization | None:
        if self._point_map is None:
            return None
        return WiredLocalization(build_localization_worker(self._profile, self._point_map))

    def step(
        self, now_ns: int, input_filter: InputFilter = unchanged, plan_late_ns: int = 0
    ) -> Outputs | None:
        """One tick, from the bus to the bus. None while there is no computer; the devices step without it.

        plan_late_ns  additional delay of the plans requested in this step
        """
        world, vehicle_id = self._world, self._vehicle_id
        reports = world.frames_to_vehicle(vehicle_id)
        items = (*world.sensor_items(vehicle_id, now_ns), *world.tracked(vehicle_id, now_ns))
        scan = world.scan(vehicle_id, now_ns)
        planar = world.planar_scan(vehicle_id, now_ns)
        if self.computer is None:
            return None
        self._bus.take_reports(reports, now_ns)
        for body in items:
            self._deliver("sensors", body, now_ns, input_filter)
        self._perception.see(scan, now_ns)
        # A stack's map is made by the sensor that it compares with it.
        placed = planar if self._profile.stack == "nus" else scan
        if placed is not None and self.localization is not None:
            self.localization.see(placed[0], now_ns)
        for percept in self._perception.due(now_ns):
            source = THINNED_SOURCE if isinstance(percept, ThinnedScan) else "worker"
            self._deliver(source, percept, now_ns, input_filter)
        while self._plans and self._plans[0][0] <= now_ns:
            self.inbox.put(now_ns, "planner", self._plans.popleft()[1])
        for answer in () if self.localization is None else self.localization.due(now_ns):
            source = MATCHED_SOURCE if isinstance(answer, MatchedScan) else "localization"
            self._deliver(source, answer, now_ns, input_filter)
        outputs = self._tick(self.computer, now_ns)
        ego, task = outputs.flow.ego, outputs.flow.task
        self._perception.take(EgoMotion(now_ns, ego.speed_mps, ego.yaw_rate_radps, task.waved_on_ns))
        self._plan(outputs.jobs, now_ns + PLAN_DELAY_NS + plan_late_ns)
        if self.localization is not None:
            self.localization.step(outputs.localization_jobs, now_ns)
        self.gate.take_commands(outputs.frames, now_ns)
        self.sent_frames = len(self._bus.send(now_ns, now_ns))
        world.show(vehicle_id, outputs.hmi, now_ns)
        return outputs

    def _deliver(self, source: str, body: InboxBody, now_ns: int, input_filter: InputFilter) -> None:
        """Put a value into the inbox; percepts are given to the gate too."""
        arrived = input_filter(body)
        if arrived is None:
            return
        self.inbox.put(now_ns, source, arrived)
        if isinstance(arrived, ObstaclePercept | TrackPercept):
            self.gate.take_percept(arrived)

    def _tick(self, computer: VehicleComputer, now_ns: int) -> Outputs:
        cpu_s, wall_ns = time.process_time(), time.perf_counter_ns()
        outputs = computer.run_tick(self.inbox.drain(), now_ns)
        self.tick_wall_ns = time.perf_counter_ns() - wall_ns
        self.tick_cpu_s = time.process_time() - cpu_s
        return outputs

    def _plan(self, jobs: tuple[PlanJob, ...], due_ns: int) -> None:
        for job in jobs:
            assert self.planner is not None, "only a stack with a planner makes jobs"
            begun_s = time.process_time()
            self._plans.append((due_ns, self.planner(job)))
            self.plan_cpu_ms.append(1e3 * (time.process_time() - begun_s))
