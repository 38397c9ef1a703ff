"""What the history learns while the service runs: from vehicles, from clients' answers, and from faults."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import msgspec

from campusloop.simulation.history.records import (
    AcknowledgedBooking,
    Journal,
    VehicleFact,
    Violation,
)
from campusloop.simulation.history.vehicles import FleetRules
from campusloop.simulation.schedule import Clock
from contract.wire.messages import (
    CommandDone,
    OrderAccepted,
    RiderAlighted,
    RiderBoarded,
    VehicleEvent,
)
from vehicle_agent.mission.memory import MissionMemory


@dataclass
class Observation:
    """seats: by vehicle. durable: events on a vehicle's disk by (vehicle, boot), then by number.

    seen         what vehicles saw of rides
    done         ids of commands that vehicles have carried out
    """

    now_s: Callable[[], float]
    clock: Clock
    rules: FleetRules
    seats: dict[str, int]
    journal: Journal = field(default_factory=Journal)
    violations: list[Violation] = field(default_factory=list)
    acknowledged: list[AcknowledgedBooking] = field(default_factory=list)
    durable: dict[tuple[str, str], dict[int, str]] = field(default_factory=dict)
    seen: list[VehicleFact] = field(default_factory=list)
    done: set[str] = field(default_factory=set)
    faults: Counter[str] = field(default_factory=Counter)
    answers: Counter[str] = field(default_factory=Counter)
    _clock_leaps: list[tuple[float, float]] = field(default_factory=lambda: [(0.0, 0.0)])
    _standing: dict[str, MissionMemory] = field(default_factory=dict)
    _reported: set[tuple[str, str]] = field(default_factory=set)

    def violated(self, violation: Violation | None) -> None:
        """Each rule is reported once for each subject."""
        if violation is None or (violation.rule, violation.subject) in self._reported:
            return
        self._reported.add((violation.rule, violation.subject))
        self.violations.append(violation)
        self.note(violation.subject, f"VIOLATION {violation.rule}: {violation.text}")

    def note(self, subject: str, what: str) -> None:
        self.journal.note(self.now_s(), subject, what)

    def fault(self, kind: str, subject: str, what: str = "") -> None:
        self.faults[kind] += 1
        self.note(subject, f"fault {kind} {what}".rstrip())

    def clock_leapt(self, ahead_s: float) -> None:
        self._clock_leaps.append((self.now_s(), ahead_s))

    # ---------------------------------------------------------------- clients

    def acknowledge(self, booking: AcknowledgedBooking) -> None:
        self.acknowledged.append(booking)
        self.note(booking.ride_id, f"acknowledged for key {booking.key}")

    def answered(self, method: str, path: str, status: int) -> None:
        self.answers[str(status)] += 1
        self.note("answer", f"{method} {path} {status}")
        if status == 500:
            self.violated(Violation(self.now_s(), "server_error", f"{method} {path}", "answered 500"))

    # ---------------------------------------------------------------- vehicles

    def durable_now(self) -> dict[tuple[str, str], dict[int, str]]:
        """The events on vehicles' disks so far; later ones may still be under way at the end."""
        return {boot: dict(events) for boot, events in self.durable.items()}

    def booted(self, vehicle_id: str, boot_id: str, memory: MissionMemory) -> None:
        order = memory.order
        self.rules.rebooted(
            vehicle_id, "" if order is None else order.order_id, 0 if order is None else order.revision
        )
        self.note(vehicle_id, f"boots as {boot_id}")

    def accepted(self, vehicle_id: str, answer: OrderAccepted, memory: MissionMemory) -> None:
        order = memory.order
        if order is None or (order.order_id, order.revision) != (answer.order_id, answer.revision):
            return
        sent_s = self._sent_s(order.expires_ns)
        self.note(vehicle_id, f"follows {order.order_id}/{order.revision}")
        self.violated(self.rules.accepted(self.now_s(), vehicle_id, order.order_id, order.revision, sent_s))

    def on_disk(self, vehicle_id: str, boot_id: str, first: int, events: tuple[VehicleEvent, ...]) -> None:
        """These events are on the vehicle's disk, numbered from `first`."""
        kept = self.durable.setdefault((vehicle_id, boot_id), {})
        for number, event in enumerate(events, start=first):
            kept[number] = msgspec.json.encode(event).decode()
            self.note(vehicle_id, f"event {boot_id}/{number} {kept[number]}")
            if isinstance(event, CommandDone) and event.done:
                self.violated(self.rules.executed(self.now_s(), vehicle_id, event.command_id))

    def happened(self, vehicle_id: str, events: tuple[VehicleEvent, ...]) -> None:
        """What the mission itself has seen; forged events are not among it."""
        for event in events:
            if isinstance(event, RiderBoarded):
                self.seen.append(VehicleFact(self.now_s(), vehicle_id, event.ride_id, "boarded"))
            elif isinstance(event, RiderAlighted):
                self.seen.append(VehicleFact(self.now_s(), vehicle_id, event.ride_id, "alighted"))
            elif isinstance(event, CommandDone) and event.done:
                self.done.add(event.command_id)

    def stands(self, vehicle_id: str, memory: MissionMemory) -> None:
        """What another vehicle takes meanwhile is checked when that one says so."""
        if self._standing.get(vehicle_id) is memory:
            return
        self._standing[vehicle_id] = memory
        aboard = {rider.ride_id: rider.party for rider in memory.aboard}
        sections = {grant.section_id: grant.fence for grant in memory.occupied}
        self.violated(self.rules.stands(self.now_s(), vehicle_id, self.seats[vehicle_id], aboard, sections))

    def _sent_s(self, expires_ns: int) -> float:
        """When an order of this expiry (server's clock) was sent; the clock may have leapt since."""
        begins_s = self.clock.begins.timestamp()
        best = 0.0
        for number, (from_s, ahead_s) in enumerate(self._clock_leaps):
            to_s = self._clock_leaps[number + 1][0] if number + 1 < len(self._clock_leaps) else self.now_s()
            sent_s = expires_ns * 1e-9 - self.rules.order_valid_s - begins_s - ahead_s
            if from_s - 0.01 <= sent_s <= to_s + 0.01:
                best = max(best, sent_s)
        return best
