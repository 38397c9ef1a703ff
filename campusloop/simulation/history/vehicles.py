"""Rules about vehicles: their orders, riders, sections and events."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from campusloop.simulation.history.records import TaskFact, Violation

# An order may be on its way, and waiting for the next step of the vehicle, for so long.
EXPIRY_SLACK_S = 3.0


@dataclass
class FleetRules:
    """What must hold at every moment. Each method returns the violation, or None.

    order_valid_s  a vehicle accepts an order within this time after it was sent
    """

    order_valid_s: float
    _revisions: dict[tuple[str, str], int] = field(default_factory=dict)
    _orders: dict[str, list[str]] = field(default_factory=dict)
    _sections: dict[str, dict[str, int]] = field(default_factory=dict)
    _aboard: dict[str, frozenset[str]] = field(default_factory=dict)
    _executed: set[str] = field(default_factory=set)

    def accepted(
        self, at_s: float, vehicle_id: str, order_id: str, revision: int, sent_s: float
    ) -> Violation | None:
        """A vehicle takes an order that was sent at sent_s: no expired one, and none that it left behind."""
        orders = self._orders.setdefault(vehicle_id, [])
        before = self._revisions.get((vehicle_id, order_id), 0)
        if before == revision and orders and orders[-1] == order_id:
            return None  # a repeat of what it follows
        if revision < before:
            text = f"took revision {revision} of {order_id} after revision {before}"
            return Violation(at_s, "order_went_back", vehicle_id, text)
        if order_id in orders[:-1]:
            return Violation(
                at_s, "order_went_back", vehicle_id, f"took {order_id}, which it had left behind"
            )
        if at_s - sent_s > self.order_valid_s + EXPIRY_SLACK_S:
            text = f"took {order_id}/{revision} {at_s - sent_s:.1f} s after it was sent"
            return Violation(at_s, "order_expired", vehicle_id, text)
        if not orders or orders[-1] != order_id:
            orders.append(order_id)
        self._revisions[vehicle_id, order_id] = revision
        return None

    def rebooted(self, vehicle_id: str, order_id: str, revision: int) -> None:
        """After a crash it follows what is on its disk, which may be older than what it took last."""
        orders = self._orders.setdefault(vehicle_id, [])
        if order_id in orders:
            del orders[orders.index(order_id) + 1 :]
        elif order_id:
            orders.append(order_id)
        else:
            orders.clear()
        known = {order for order in orders if order != order_id}
        self._revisions = {
            (vehicle, order): seen
            for (vehicle, order), seen in self._revisions.items()
            if vehicle != vehicle_id or order in known
        }
        if order_id:
            self._revisions[vehicle_id, order_id] = revision

    def executed(self, at_s: float, vehicle_id: str, command_id: str) -> Violation | None:
        """A vehicle has carried out a command, and has that on its disk: once."""
        if command_id in self._executed:
            return Violation(at_s, "command_repeated", vehicle_id, f"carried out {command_id} again")
        self._executed.add(command_id)
        return None

    def stands(
        self,
        at_s: float,
        vehicle_id: str,
        seats: int,
        aboard: Mapping[str, int],
        sections: Mapping[str, int],
    ) -> Violation | None:
        """aboard: party by ride; sections: fence of each section that the body is in."""
        taken = sum(aboard.values())
        if taken > seats:
            return Violation(at_s, "seats_exceeded", vehicle_id, f"{taken} people aboard on {seats} seats")
        self._sections[vehicle_id] = dict(sections)
        self._aboard[vehicle_id] = frozenset(aboard)
        for other, theirs in self._sections.items():
            shared = sections.keys() & theirs.keys() if other != vehicle_id else ()
            if shared:
                return Violation(
                    at_s, "section_shared", vehicle_id, f"in section {min(shared)} together with {other}"
                )
        for other, rides in self._aboard.items():
            twice = rides & aboard.keys() if other != vehicle_id else ()
            if twice:
                return Violation(at_s, "rider_twice", vehicle_id, f"{min(twice)} is aboard it and {other}")
        return None


def lost_events(
    at_s: float, vehicle_id: str, boot_id: str, durable: Mapping[int, str], stored: Mapping[int, str]
) -> list[Violation]:
    """Events by number: those that a vehicle has on disk are stored, each as it was, none missing between."""
    found = []
    lost = sorted(durable.keys() - stored.keys())
    if lost:
        text = f"event {lost[0]} of {boot_id} is not stored ({durable[lost[0]]}); {len(lost)} in all"
        found.append(Violation(at_s, "event_lost", vehicle_id, text))
    other = [number for number in sorted(durable.keys() & stored.keys()) if durable[number] != stored[number]]
    if other:
        number = other[0]
        text = f"event {number} of {boot_id} was {durable[number]} and is stored as {stored[number]}"
        found.append(Violation(at_s, "event_changed", vehicle_id, text))
    return found


def doubled_events(at_s: float, vehicle_id: str, boot_id: str, numbers: Iterable[int]) -> list[Violation]:
    """numbers: of the boot's stored events, one for each time that it is stored."""
    twice = sorted(number for number, times in Counter(numbers).items() if times > 1)
    if not twice:
        return []
    text = f"event {twice[0]} of {boot_id} is stored more than once; {len(twice)} are in all"
    return [Violation(at_s, "event_doubled", vehicle_id, text)]


def stuck_outboxes(
    at_s: float, oldest_before: Mapping[str, tuple[str, int]], oldest_now: Mapping[str, tuple[str, int]]
) -> list[Violation]:
    """A vehicle whose oldest unacknowledged event (boot, number) is the same as minutes before."""
    return [
        Violation(at_s, "outbox_stuck", vehicle_id, f"event {oldest[1]} of {oldest[0]} is not acknowledged")
        for vehicle_id, oldest in sorted(oldest_before.items())
        if oldest_now.get(vehicle_id) == oldest
    ]


def leaked_sections(
    at_s: float,
    vehicle_id: str,
    held: Collection[tuple[str, int]],
    left: Collection[tuple[str, int]],
) -> list[Violation]:
    """Grants that the server takes as held though the vehicle has left them: no other vehicle gets them."""
    return [
        Violation(at_s, "section_leaked", vehicle_id, f"{section_id} (fence {fence}) is held, but was left")
        for section_id, fence in sorted(set(held) & set(left))
    ]


def several_orders(at_s: float, open_orders: Mapping[str, Collection[str]]) -> list[Violation]:
    """A vehicle with more than one order in force, by the store. open_orders: order ids by vehicle."""
    return [
        Violation(at_s, "several_orders", vehicle_id, f"in force: {', '.join(sorted(order_ids))}")
        for vehicle_id, order_ids in sorted(open_orders.items())
        if len(order_ids) > 1
    ]


def unreachable(at_s: float, vehicles: Sequence[str], reached: Collection[str]) -> list[Violation]:
    """A vehicle that did not carry out the command of the last check."""
    return [
        Violation(at_s, "vehicle_unreachable", vehicle_id, "did not carry out a command after the faults")
        for vehicle_id in vehicles
        if vehicle_id not in reached
    ]


def dead_tasks(at_s: float, tasks: Iterable[TaskFact]) -> list[Violation]:
    """A standing task that has ended, fails, or whose cycles have stopped."""
    found = []
    for task in tasks:
        late = task.idle_s is not None and task.idle_s > 2.0 * task.period_s + 30.0
        if not task.is_running or task.failures or late:
            state = "has ended" if not task.is_running else f"failures {task.failures}, idle {task.idle_s} s"
            found.append(Violation(at_s, "task_dead", task.name, state))
    return found
