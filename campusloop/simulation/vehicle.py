"""A vehicle of the fleet: the real mission, outbox and link session over a light body."""

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import msgspec
import numpy as np

from campusloop.simulation.body import Body
from campusloop.simulation.clocks import BootClock
from campusloop.simulation.network import Network
from campusloop.simulation.timeline import Timeline
from campusloop.simulation.vehicle_disk import ComputerCrashed, VehicleDisk
from campusloop.simulation.vehicle_link import VehicleLink
from contract.wire.messages import DriveMode, ModeChanged, OrderAccepted, RiderTask, Status, VehicleEvent
from vehicle_agent.link.bridge import LinkBridge, TickUpdate
from vehicle_agent.link.outbox import read_memory
from vehicle_agent.link.session import Identity, Sign
from vehicle_agent.mission.boarding import riders_to_alight, riders_to_board
from vehicle_agent.mission.memory import MissionMemory, order_progress
from vehicle_agent.mission.mission import Mission
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import (
    CodeTyped,
    FleetVehicle,
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
REBOOT_S = (15.0, 60.0)
DRIFT_MAX = 5e-5
BATTERY_PER_DRIVE_S, BATTERY_PER_REST_S = 8e-5, 2.1e-4

_MOTION = VehicleMotion(1, 0.0, 0.0, 0.0, 0.0, True, False, True, 1.0)
_EMPTY_WORLD = World(0, 0, np.empty((0, 2)), (), (), False)


class Cabin(Protocol):
    """The people at a vehicle's doors."""

    def codes(
        self, vehicle_id: str, boarding: tuple[RiderTask, ...], alighting: tuple[RiderTask, ...]
    ) -> tuple[str, ...]:
        """The codes that are typed now."""
        ...


class Observer(Protocol):
    """What the history learns of a vehicle, in the order in which it is true."""

    def booted(self, vehicle_id: str, boot_id: str, memory: MissionMemory) -> None: ...

    def accepted(self, vehicle_id: str, answer: OrderAccepted, memory: MissionMemory) -> None: ...

    def happened(self, vehicle_id: str, events: tuple[VehicleEvent, ...]) -> None: ...

    def on_disk(
        self, vehicle_id: str, boot_id: str, first: int, events: tuple[VehicleEvent, ...]
    ) -> None: ...

    def stands(self, vehicle_id: str, memory: MissionMemory) -> None: ...


@dataclass(frozen=True, slots=True)
class VehicleSetup:
    vehicle_id: str
    folder: Path
    mission: Mission
    seats: int
    wheelchair_places: int
    sign: Sign


class SimulatedVehicle:
    """`boot`, then it steps by itself; `crash` ends the computer, and the disk and the body stay."""

    def __init__(
        self,
        setup: VehicleSetup,
        body: Body,
        timeline: Timeline,
        network: Network,
        cabin: Cabin,
        observer: Observer,
    ) -> None:
        self.setup, self.body = setup, body
        self.boot_id = ""
        self.forged: list[VehicleEvent] = []
        self.rng: random.Random = timeline.rng(setup.vehicle_id)
        self.disk = VehicleDisk(setup.folder, self.rng)
        self.battery_ratio = self.rng.uniform(0.5, 1.0)
        self._timeline, self._network, self._cabin, self._observer = timeline, network, cabin, observer
        self._boots = 0
        self._is_frozen = False
        self._computer: _Computer | None = None

    @property
    def is_running(self) -> bool:
        return self._computer is not None and not self._is_frozen

    @property
    def link(self) -> VehicleLink | None:
        return None if self._computer is None else self._computer.link

    @property
    def memory(self) -> MissionMemory | None:
        """What the computer knows of its orders; None while it is off."""
        return None if self._computer is None else self._computer.state.memory

    @property
    def oldest_event(self) -> tuple[str, int] | None:
        """Boot and number of the oldest event that the server has not acknowledged."""
        return None if self._computer is None else self._computer.oldest_event()

    @property
    def is_held(self) -> bool:
        return self._computer is not None and self._computer.state.held

    def boot(self) -> None:
        """A new boot with the memory on disk."""
        self._boots += 1
        self._is_frozen = False
        self.boot_id = f"{self.setup.vehicle_id}-boot-{self._boots}"
        clock = BootClock(self._timeline, self._timeline.now_ns, self.rng.uniform(-DRIFT_MAX, DRIFT_MAX))
        self.body.new_computer()
        self._computer = _Computer(self, clock, self._timeline, self._network, self._cabin, self._observer)

    def crash(self) -> None:
        """Power is lost; it is back after a while."""
        if self._computer is None:
            return
        self._computer.end()
        self._computer = None
        self.body.speed_mps = 0.0
        self._timeline.after(self.rng.uniform(*REBOOT_S), self._boot_again)

    def freeze(self, duration_s: float) -> None:
        """The computer stands still and the gate brakes; then it goes on where it was."""
        computer = self._computer
        if computer is None or self._is_frozen:
            return
        self._is_frozen = True
        computer.freeze()
        self._timeline.after(duration_s, lambda: self._thaw(computer))

    def _thaw(self, computer: "_Computer") -> None:
        if computer is self._computer and self._is_frozen:
            self._is_frozen = False
            computer.thaw()

    def _boot_again(self) -> None:
        if self._computer is None:
            self.boot()


class _Computer:
    """One boot: the mission's state, the link, and the steps."""

    def __init__(
        self,
        vehicle: SimulatedVehicle,
        clock: BootClock,
        timeline: Timeline,
        network: Network,
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
        self._bridge = LinkBridge(setup.folder, identity, setup.sign, order_progress(memory), sync=False)
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
            setup.vehicle_id, self._bridge.session, clock, network, timeline, self._messages_arrived
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
    arrived: list[MissionMessage | LinkState | FleetVehicle | PedestrianPresence],
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


