"""One boot of a vehicle's computer: the real mission, outbox and link session, step by step."""

import random
from pathlib import Path
from typing import Protocol

import msgspec
import numpy as np

from campusloop.simulation.clocks import BootClock
from campusloop.simulation.fleet.body import Body
from campusloop.simulation.fleet.surroundings import Cabin, Observer, VehicleSetup
from campusloop.simulation.fleet.vehicle_disk import ComputerCrashed, VehicleDisk
from campusloop.simulation.fleet.vehicle_link import VehicleLink
from campusloop.simulation.schedule import Dialler, Schedule
from contract.wire.messages import DriveMode, ModeChanged, OrderAccepted, Status, VehicleEvent
from vehicle_agent.link.bridge import LinkBridge, TickUpdate
from vehicle_agent.link.outbox import read_memory
from vehicle_agent.link.redial import Redial
from vehicle_agent.link.session import Identity
from vehicle_agent.mission.boarding import riders_to_alight, riders_to_board
from vehicle_agent.mission.memory import MissionMemory, order_progress
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import (
    CodeTyped,
    FleetVehicle,
    LinkMessage,
    LinkState,
    MissionMessage,
    PedestrianPresence,
    Task,
    VehicleMotion,
    World,
)

# A vehicle moves less than its own length in a step, so that it is seen in every section that it passes.
STEP_S = 1.3
IDLE_STEP_S = 3.0
# A step that messages ask for comes at most this soon after the last one.
SOONEST_S = 0.1
BATTERY_PER_DRIVE_S, BATTERY_PER_REST_S = 8e-5, 2.1e-4

_MOTION = VehicleMotion(1, 0.0, 0.0, 0.0, 0.0, True, False, True, 1.0)
_EMPTY_WORLD = World(0, 0, np.empty((0, 2)), (), (), False)


class Host(Protocol):
    """The vehicle around the computer. forged: events of no mission, to be sent with the next."""

    setup: VehicleSetup
    body: Body
    disk: VehicleDisk
    rng: random.Random
    boot_id: str
    battery_ratio: float
    forged: list[VehicleEvent]

    def crash(self) -> None: ...


class Computer:
    """One boot: the mission's state, the link, and the steps."""

    def __init__(
        self,
        vehicle: Host,
        clock: BootClock,
        timeline: Schedule,
        network: Dialler,
        cabin: Cabin,
        observer: Observer,
    ) -> None:
        self._vehicle, self._clock, self._timeline = vehicle, clock, timeline
        self._cabin, self._observer = cabin, observer
        setup = vehicle.setup
        self._mission = setup.mission
        memory = _memory_on_disk(setup.folder)
        self.state: MissionState = self._mission.initial(memory)
        observer.booted(setup.vehicle_id, vehicle.boot_id, memory)
        identity = Identity(
            setup.vehicle_id,
            vehicle.boot_id,
            "simulation",
            "light",
            self._mission.network.map_version,
            setup.seats,
            setup.wheelchair_places,
        )
        self._bridge = LinkBridge(
            setup.folder, identity, setup.sign, order_progress(memory), sync=setup.syncs_disk
        )
        self._saved = memory
        self._task: Task | None = None
        self._numbered = 0
        self._mode: tuple[DriveMode, str | None, str] = ("held", "just_started", "")
        self._stepped_ns = timeline.now_ns
        self._reported_ns = 0
        self._due_ns = 0
        self._is_over = False
        self._is_frozen = False
        self.link = VehicleLink(
            setup.vehicle_id,
            self._bridge.session,
            clock,
            network,
            timeline,
            self._messages_arrived,
            Redial(vehicle.rng.random),
        )
        self._step_after(vehicle.rng.uniform(0.1, STEP_S))

    def end(self) -> None:
        self._is_over = True
        self.link.drop()
        self._bridge.close()

    def oldest_event(self) -> tuple[str, int] | None:
        pending = self._bridge.session.log.pending()
        return (pending[0].boot_id, pending[0].sequence) if pending else None

    def freeze(self) -> None:
        self._is_frozen = True
        self._vehicle.body.speed_mps = 0.0
        self.link.freeze()

    def thaw(self) -> None:
        self._is_frozen = False
        self._stepped_ns = self._timeline.now_ns
        self.link.thaw()
        self._step_after(SOONEST_S)

    # ---------------------------------------------------------------- steps

    def _messages_arrived(self) -> None:
        self._step_after(SOONEST_S)

    def _step_after(self, delay_s: float) -> None:
        due_ns = self._timeline.now_ns + round(delay_s * 1e9)
        if self._due_ns <= self._timeline.now_ns or due_ns < self._due_ns:
            self._due_ns = due_ns
            self._timeline.at(due_ns, lambda: self._step_if_due(due_ns))

    def _step_if_due(self, due_ns: int) -> None:
        if due_ns != self._due_ns or self._is_over or self._is_frozen:
            return
        try:
            self._step()
        except ComputerCrashed:
            self._vehicle.crash()
            return
        is_resting = self._task is not None and self._task.mode in ("idle", "hold")
        stands = is_resting and self._vehicle.body.speed_mps == 0.0
        self._step_after(IDLE_STEP_S if stands else STEP_S)

    def _step(self) -> None:
        now_ns, body = self._clock.now_ns(), self._vehicle.body
        elapsed_s = (self._timeline.now_ns - self._stepped_ns) * 1e-9
        self._stepped_ns = self._timeline.now_ns
        if self._task is not None and elapsed_s > 0.0:
            body.drive(self._task, elapsed_s)
            self._use_battery(elapsed_s)
        messages, link = _sorted(self._bridge.session.take_messages())
        task, self.state = self._mission.step(
            self.state,
            messages,
            self._typed(now_ns),
            link,
            body.ego(now_ns),
            _MOTION,
            _EMPTY_WORLD,
            now_ns,
        )
        self._task = task
        memory = self.state.memory
        for answer in self.state.answers:
            if isinstance(answer, OrderAccepted):
                self._observer.accepted(self._vehicle.setup.vehicle_id, answer, memory)
        self._tell(task, now_ns)
        self._observer.stands(self._vehicle.setup.vehicle_id, memory)
        self.link.advance()

    def _tell(self, task: Task, now_ns: int) -> None:
        """Write to disk and send, as the tick and the link processes do."""
        vehicle, memory = self._vehicle, self.state.memory
        events = (*self.state.events, *self._mode_events(task))
        told = (*events, *vehicle.forged)
        vehicle.forged = []
        has_changed = memory is not self._saved and memory != self._saved
        is_due = now_ns - self._reported_ns >= round(0.9e9 * STEP_S)
        if not (told or self.state.answers or has_changed or is_due):
            return
        if is_due or told:
            self._reported_ns = now_ns
        update = TickUpdate(
            stamp_ns=now_ns,
            report=self._status(task, now_ns) if is_due or told else None,
            events=told,
            answers=self.state.answers,
            memory=msgspec.msgpack.encode(memory) if has_changed else None,
            progress=order_progress(memory) if has_changed else None,
        )
        self._saved = memory
        self._observer.happened(vehicle.setup.vehicle_id, events)
        vehicle.disk.process(self._bridge, update, now_ns)
        if told:
            self._observer.on_disk(vehicle.setup.vehicle_id, vehicle.boot_id, self._numbered, told)
            self._numbered += len(told)

    def _mode_events(self, task: Task) -> tuple[VehicleEvent, ...]:
        mode: DriveMode = "held" if task.mode == "hold" else "autonomous"
        now = (mode, task.hold_reason, task.hold_detail)
        if now == self._mode:
            return ()
        self._mode = now
        return (ModeChanged(mode, task.hold_reason, task.hold_detail),)

    def _typed(self, now_ns: int) -> tuple[CodeTyped, ...]:
        if self.state.doors.phase != "open":
            return ()
        visit, memory = self.state.visit_here(), self.state.memory
        codes = self._cabin.codes(
            self._vehicle.setup.vehicle_id, riders_to_board(visit, memory), riders_to_alight(visit, memory)
        )
        return tuple(CodeTyped(now_ns, code) for code in codes)

    def _use_battery(self, elapsed_s: float) -> None:
        vehicle = self._vehicle
        change = -BATTERY_PER_DRIVE_S if vehicle.body.speed_mps else BATTERY_PER_REST_S
        vehicle.battery_ratio = min(1.0, max(0.0, vehicle.battery_ratio + change * elapsed_s))

    def _status(self, task: Task, now_ns: int) -> Status:
        body = self._vehicle.body
        return Status(
            epoch=0,
            stamp_ns=now_ns,
            pose_map=body.pose_map,
            speed_mps=body.speed_mps,
            accel_mps2=0.0,
            steer_rad=0.0,
            mode=self._mode[0],
            battery_ratio=self._vehicle.battery_ratio,
            doors_open=task.doors_open,
            lane_id=task.lane_id,
            s_m=task.lane_s_m,
            order_id=task.order_id,
            revision=task.revision,
            visit_id=task.visit_id,
            aboard=task.aboard,
            waiting_for=task.waiting_for,
            hold_reason=task.hold_reason,
            hold_detail=task.hold_detail,
        )


def _sorted(
    arrived: list[LinkMessage],
) -> tuple[tuple[MissionMessage, ...], LinkState | None]:
    """The messages for the mission, and the newest state of the link; a light vehicle sees no others."""
    messages: list[MissionMessage] = []
    link: LinkState | None = None
    for message in arrived:
        if isinstance(message, LinkState):
            link = message
        elif not isinstance(message, FleetVehicle | PedestrianPresence):
            messages.append(message)
    return tuple(messages), link


def _memory_on_disk(folder: Path) -> MissionMemory:
    data = read_memory(folder)
    return MissionMemory() if data is None else msgspec.msgpack.decode(data, type=MissionMemory)
