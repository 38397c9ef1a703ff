"""The tick as a process: pacer, inbox, tick, and mail to the other processes."""

import gc
import signal
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Protocol

import msgspec
import structlog

from contract.wire.messages import OnboardScene
from vehicle_agent.link.bridge import TickUpdate
from vehicle_agent.mission.memory import MissionMemory, order_progress
from vehicle_agent.mission.state import MissionState
from vehicle_agent.onboard.cabin_view import CabinView, cabin_view, is_for_cabin
from vehicle_agent.onboard.driving_view import report_with_driving_view
from vehicle_agent.runtime.code_mask import CodeMask
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.inbox import Inbox
from vehicle_agent.runtime.order_tracing import TickTracing
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.link.link_mail import LinkMail
from vehicle_agent.runtime.processes.mailbox import (
    CabinUpdate,
    Commands,
    Deliveries,
    LocalizationJobs,
    LocalizationMapOffer,
    Mail,
    Mailbox,
    MailedSpans,
    MapOffer,
    PlannerJobs,
    TickMotion,
)
from vehicle_agent.runtime.processes.maps.localization_switch import LocalizationSwitch
from vehicle_agent.runtime.processes.maps.map_switch import MapSwitch
from vehicle_agent.runtime.processes.pacing import Pacer
from vehicle_agent.runtime.processes.priority import TICK_PRIORITY, ask_for_real_time
from vehicle_agent.signals import HmiOutput, InboxBody, LinkState, Outputs
from vehicle_agent.signals.objects import EgoMotion
from vehicle_agent.signals.rates import LATE_TICK_FAULT_NS, REPORT_EVERY_TICKS

log = structlog.get_logger()

# Screen, speaker and doors get every change, and repeats in case a device was away.
SHOW_EVERY_NS = 1_000_000_000

Show = Callable[[HmiOutput], None]


class Sensors(Protocol):
    """Devices that the tick process reads without waiting."""

    def poll(self) -> list[tuple[str, InboxBody]]:
        """(source, value) of all values since the last poll."""
        ...


class TickUpdateWriter:
    """Makes the link's update from each tick's outputs: changes only."""

    def __init__(self) -> None:
        self._ticks = 0
        self._memory: MissionMemory | None = None

    def update(
        self, outputs: Outputs, memory: MissionMemory, stamp_ns: int, scene: OnboardScene | None
    ) -> TickUpdate | None:
        """The update of a tick, None without changes. Status goes at 5 Hz and with every event.

        scene: for an operator who asked for it
        """
        is_due = self._ticks % REPORT_EVERY_TICKS == 0
        self._ticks += 1
        memory_changed = memory is not self._memory and memory != self._memory
        self._memory = memory
        if not (is_due or memory_changed or outputs.events or outputs.answers or scene is not None):
            return None
        return TickUpdate(
            stamp_ns=stamp_ns,
            report=report_with_driving_view(outputs) if is_due or outputs.events else None,
            events=outputs.events,
            answers=outputs.answers,
            memory=msgspec.msgpack.encode(memory) if memory_changed else None,
            progress=order_progress(memory) if memory_changed else None,
            scene=scene,
        )


class CabinReporter:
    """Makes the onboard screen's view: at 5 Hz, and in ticks that passengers must learn of."""

    def __init__(self, speed_mps_max: float) -> None:
        self._speed_mps_max = speed_mps_max
        self._ticks = 0
        self._connected: bool | None = None

    def note_link(self, connected: bool) -> None:
        self._connected = connected

    def view(self, outputs: Outputs, mission: MissionState) -> CabinView | None:
        is_due = self._ticks % REPORT_EVERY_TICKS == 0
        self._ticks += 1
        if not is_due and not is_for_cabin(outputs):
            return None
        return cabin_view(outputs, mission, self._connected, self._speed_mps_max)


class TickProcess:
    """One vehicle's onboard loop."""

    def __init__(
        self,
        mail: Path,
        computer: VehicleComputer,
        sensors: Sensors,
        show: Show,
        clock: Clock,
        mask: CodeMask,
        traced: str = "",
        cabin: CabinReporter | None = None,
        maps: MapSwitch | None = None,
        scans: LocalizationSwitch | None = None,
        *,
        worker_tracks: bool = False,
    ) -> None:
        """mail: the folder of the vehicle's mailboxes; traced: the vehicle, if its rides are traced.

        cabin: None for a vehicle without an onboard screen; maps: None for one whose map never changes;
        scans: None for one that compares no scans with a map
        worker_tracks: the perception worker tracks road users, and needs the vehicle's motion
        """
        self._worker_tracks = worker_tracks
        self._scans = scans
        self._cabin = cabin
        self._maps = maps
        self._mail = mail
        self._clock = clock
        self._mailbox = Mailbox(mail / "tick", self._note_lost)
        self._link_mail = LinkMail(self._mailbox, mail / "link")
        self._computer = computer
        self._sensors = sensors
        self._show = show
        self._inbox = Inbox(mask=mask)
        self._update_writer = TickUpdateWriter()
        self._tracing = TickTracing(MailedSpans(self._mailbox, mail / "link"), traced) if traced else None
        self._utc_offset_ns = clock.utc_offset_ns()
        self._shown: HmiOutput | None = None
        self._shown_ns = 0
        self._dropped = 0
        self._stopping = False

    def run(self) -> None:
        """Runs until SIGTERM. An exception in the tick ends the process; the gate brakes, it restarts."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        ask_for_real_time("tick", TICK_PRIORITY)
        gc.collect()
        gc.freeze()
        pacer = Pacer(self._clock)
        while not self._stopping:
            now_ns = pacer.wait()
            if pacer.late_ns > LATE_TICK_FAULT_NS:
                log.warning("tick.late", late_ms=pacer.late_ns / 1e6)
            self._collect()
            outputs = self._computer.run_tick(self._inbox.drain(), now_ns, pacer.late_ns)
            self._send_outputs(outputs, now_ns)
            self._change_map(outputs)
            self._change_localization_map()
        self._mailbox.close()

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True

    def _collect(self) -> None:
        for mail in self._mailbox.take():
            if isinstance(mail, Deliveries):
                for delivery in mail.items:
                    if self._cabin is not None and isinstance(delivery.body, LinkState):
                        self._cabin.note_link(delivery.body.connected)
                    self._inbox.put(delivery.arrival_ns, delivery.source, delivery.body)
            elif isinstance(mail, MapOffer) and self._maps is not None:
                self._maps.offer(mail.map_version)
            elif isinstance(mail, LocalizationMapOffer) and self._scans is not None:
                self._scans.offer(mail.map_version)
        now_ns = self._clock.now_ns()
        for source, body in self._sensors.poll():
            self._inbox.put(now_ns, source, body)
        dropped = self._inbox.dropped.total()
        if dropped > self._dropped:
            self._dropped = dropped
            log.warning("inbox.dropped", by_source=dict(self._inbox.dropped))

    def _send_outputs(self, outputs: Outputs, now_ns: int) -> None:
        """Sends the outputs; frames first."""
        self._mailbox.post(self._mail / "gate", Commands(outputs.frames, self._moved(outputs, now_ns)))
        if outputs.jobs:
            self._mailbox.post(self._mail / "planner", PlannerJobs(outputs.jobs))
        if outputs.localization_jobs:
            self._mailbox.post(self._mail / "localization", LocalizationJobs(outputs.localization_jobs))
        if self._worker_tracks:
            ego, task = outputs.flow.ego, outputs.flow.task
            motion = EgoMotion(now_ns, ego.speed_mps, ego.yaw_rate_radps, task.waved_on_ns)
            self._mailbox.post(self._mail / "worker", TickMotion(motion))
        if outputs.hmi != self._shown or now_ns - self._shown_ns >= SHOW_EVERY_NS:
            self._shown, self._shown_ns = outputs.hmi, now_ns
            self._show(outputs.hmi)
        if self._cabin is not None:
            view = self._cabin.view(outputs, self._computer.state.mission)
            if view is not None:
                self._mailbox.post(self._mail / "screen", CabinUpdate(view))
        memory = self._computer.state.mission.memory
        update = self._update_writer.update(outputs, memory, now_ns, self._computer.shown)
        if self._link_mail.post(update, self._computer.entries):
            self._computer.begin_segment()

    def _change_map(self, outputs: Outputs) -> None:
        answer = None if self._maps is None else self._maps.poll(self._computer, outputs)
        if answer is None:
            return
        # Those of the new rooms stay for good, too.
        gc.freeze()
        self._mailbox.post(self._mail / "link", answer)
        if self._cabin is not None:
            self._mailbox.post(self._mail / "screen", answer)
        if self._scans is not None:
            self._mailbox.post(self._mail / "localization", answer)

    def _change_localization_map(self) -> None:
        answer = None if self._scans is None else self._scans.poll(self._computer)
        if answer is not None:
            self._mailbox.post(self._mail / "localization", answer)
            self._mailbox.post(self._mail / "link", answer)

    def _note_lost(self, mail: Mail) -> None:
        self._link_mail.note_lost(mail)

    def _moved(self, outputs: Outputs, now_ns: int) -> tuple[str, ...]:
        if self._tracing is None:
            return ()
        memory = self._computer.state.mission.memory
        return self._tracing.moved(outputs, memory, now_ns + self._utc_offset_ns)
