"""The gate as a process: the only one that opens the CAN bus."""

import signal
import time
from pathlib import Path
from types import FrameType

import can
import structlog

from vehicle_agent.can.by_wire import braking_of
from vehicle_agent.config import Profile
from vehicle_agent.gate.footprint import warm_footprint
from vehicle_agent.gate.gate import gate_of
from vehicle_agent.runtime.devices.can_bus import open_bus
from vehicle_agent.runtime.order_tracing import GateTracing
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import (
    Commands,
    Deliveries,
    Delivery,
    Mailbox,
    MailedSpans,
)
from vehicle_agent.runtime.processes.priority import GATE_PRIORITY, ask_for_real_time
from vehicle_agent.signals import CanFrame, ObstaclePercept, TrackPercept
from vehicle_agent.signals.rates import TICK_NS

log = structlog.get_logger()

# Frames that arrive within this time go to the tick as one mail: a module sends hundreds of frames a second,
# and the tick's queue holds ten mails on many kernels.
FORWARD_AFTER_NS = 4_000_000


class GateProcess:
    """Moves frames both ways; `Gate` decides."""

    def __init__(self, folder: Path, channel: str, profile: Profile, clock: Clock, traced: str = "") -> None:
        """folder: of the vehicle's mailboxes; channel: see `open_bus`.

        traced  the vehicle, if its rides are traced
        """
        by_wire = braking_of(profile)
        warm_footprint()
        self._clock = clock
        self._gate = gate_of(profile)
        self._frame_gap_s = by_wire.frame_gap_ns / 1e9
        self._bus = open_bus(channel)
        self._mailbox = Mailbox(folder / "gate")
        self._tick = folder / "tick"
        self._tracing = GateTracing(MailedSpans(self._mailbox, folder / "link"), traced) if traced else None
        self._utc_offset_ns = clock.utc_offset_ns()
        self._stopping = False
        self._unforwarded: list[CanFrame] = []
        # A simulated bus returns a sender's own frames.
        self._own_ids = by_wire.command_ids()

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        ask_for_real_time("gate", GATE_PRIORITY)
        due_ns = self._clock.now_ns() + TICK_NS
        was_braking = ""
        while not self._stopping:
            self._clock.wait(self._wake_ns(due_ns), (self._bus.fileno(), self._mailbox.fileno()))
            self._take_reports()
            has_commands = self._take_commands()
            now_ns = self._clock.now_ns()
            if has_commands or now_ns >= due_ns:
                frames = self._gate.step(now_ns)
                self._send(frames)
                if self._tracing is not None:
                    utc_ns = self._clock.now_ns() + self._utc_offset_ns
                    self._tracing.sent(len(frames), bool(self._gate.braking), utc_ns)
                self._send_to_tick(self._gate.report_frames(now_ns))
                due_ns = now_ns + TICK_NS
            if self._gate.braking != was_braking:
                was_braking = self._gate.braking
                log.warning("gate.braking" if was_braking else "gate.released", reason=was_braking)
        self._bus.shutdown()
        self._mailbox.close()

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True

    def _take_commands(self) -> bool:
        has_commands = False
        for mail in self._mailbox.take():
            if isinstance(mail, Commands):
                self._gate.take_commands(mail.frames, self._clock.now_ns())
                if self._tracing is not None:
                    self._tracing.commanded(mail.rides, self._clock.now_ns() + self._utc_offset_ns)
                has_commands = True
            elif isinstance(mail, Deliveries):
                self._take_percepts(mail)
        return has_commands

    def _take_percepts(self, mail: Deliveries) -> None:
        """Takes percepts, which the worker posts to tick and gate."""
        for delivery in mail.items:
            if isinstance(delivery.body, ObstaclePercept | TrackPercept):
                self._gate.take_percept(delivery.body)

    def _take_reports(self) -> None:
        frames = []
        while (message := self._bus.recv(timeout=0)) is not None:
            if message.arbitration_id in self._own_ids:
                continue
            frames.append(CanFrame(self._clock.now_ns(), message.arbitration_id, bytes(message.data)))
        if frames:
            self._gate.take_reports(tuple(frames), frames[-1].stamp_ns)
            self._unforwarded.extend(frames)
        if self._unforwarded and self._clock.now_ns() - self._unforwarded[0].stamp_ns >= FORWARD_AFTER_NS:
            self._send_to_tick(tuple(self._unforwarded))
            self._unforwarded.clear()

    def _wake_ns(self, due_ns: int) -> int:
        """When to go on at the latest: for the gate's step, or to forward frames."""
        return min(due_ns, self._unforwarded[0].stamp_ns + FORWARD_AFTER_NS) if self._unforwarded else due_ns

    def _send_to_tick(self, frames: tuple[CanFrame, ...]) -> None:
        if frames:
            deliveries = tuple(Delivery(frame.stamp_ns, "can", frame) for frame in frames)
            self._mailbox.post(self._tick, Deliveries(deliveries))

    def _send(self, frames: tuple[CanFrame, ...]) -> None:
        """Sends frames with the pause that the by-wire module needs between them."""
        for number, frame in enumerate(frames):
            if number:
                time.sleep(self._frame_gap_s)
            self._bus.send(
                can.Message(arbitration_id=frame.arbitration_id, data=frame.data, is_extended_id=False)
            )
