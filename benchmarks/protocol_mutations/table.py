"""Wrong changes to the protocol, picked by hand: each once looked reasonable to someone."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ProtocolMutation:
    """danger: what it does to riders or vehicles.

    test  the short test that notices it where the simulation does not, "" for none
    """

    name: str
    path: str
    was: str
    now: str
    danger: str
    test: str = ""


M = ProtocolMutation

MUTATIONS: tuple[ProtocolMutation, ...] = (
    # ------------------------------------------------------------ events: vehicle to server
    M(
        "acknowledgement dropped",
        "server/fleet/session.py",
        "return self.send(EventsAcknowledged(self.epoch, boot_id, next_sequence))",
        "return ()",
        "outboxes grow until the vehicle's disk is full",
    ),
    M(
        "acknowledged before the commit",
        "server/fleet/event_intake.py",
        "        applying = asyncio.ensure_future(self._apply(batch))",
        "        for waiting in batch:\n"
        "            early = {waiting.report.boot_id: waiting.report.sequence + 1}\n"
        "            waiting.link.events_stored(early, 0)\n"
        "        applying = asyncio.ensure_future(self._apply(batch))",
        "a crash between loses events for good",
    ),
    M(
        "events not deduplicated",
        "contract/wire/sequence.py",
        "    return sequence == expected",
        "    return True",
        "a repeated event fails or takes effect twice",
    ),
    M(
        "gap ignored",
        "contract/wire/sequence.py",
        "    if sequence > expected:\n        raise SequenceGap(boot_id, expected, sequence)\n"
        "    return sequence == expected",
        "    return sequence >= expected",
        "what is missing between is never stored",
        "tests/contract/wire/test_sequence.py",
    ),
    M(
        "stored events counted wrong",
        "server/store/record/events.py",
        "(event.vehicle_id, event.boot_id): event.sequence + 1 for",
        "(event.vehicle_id, event.boot_id): event.sequence for",
        "the next event has the number of a stored one",
    ),
    M(
        "one event too many forgotten",
        "contract/wire/sequence.py",
        "kept[0].sequence < next_sequence",
        "kept[0].sequence <= next_sequence",
        "an event that is not stored leaves the outbox",
    ),
    M(
        "resent with a new number",
        "vehicle_agent/link/session.py",
        "return EventReport(epoch, event.boot_id, event.sequence, event.stamp_ns, event.body)",
        "return EventReport(epoch, event.boot_id, event.sequence + epoch - 1, event.stamp_ns, event.body)",
        "after a reconnection the server waits for numbers that never come",
    ),
    M(
        "earlier boots forgotten",
        "vehicle_agent/link/outbox.py",
        "self.log = EventLog(boot_id, self._read_pending())",
        "self.log = EventLog(boot_id)",
        "what happened before a crash of the vehicle never reaches the server",
    ),
    M(
        "events not written to disk",
        "vehicle_agent/link/outbox.py",
        "unwritten = unwritten[self._file.write(unwritten) :]",
        "unwritten = unwritten[len(unwritten) :]",
        "a crash of the vehicle loses what was not acknowledged",
    ),
    M(
        "memory without its events",
        "vehicle_agent/link/outbox.py",
        "msgspec.msgpack.encode(SavedMemory(memory, lines))",
        "msgspec.msgpack.encode(SavedMemory(memory))",
        "a power loss between two files: sections are held for ever",
        "tests/vehicle_agent/link/test_outbox.py",
    ),
    M(
        "another vehicle's riders",
        "server/usecases/rides/boarding.py",
        "    if vehicle_id in (ride.vehicle_id, ride.stranded_by) or ",
        "    if True or ",
        "one vehicle boards and completes the rides of all",
    ),
    M(
        "releases without effect",
        "server/usecases/orders/sections.py",
        "    if SectionReservations(uow).release(vehicle_id, section_id, fence):",
        "    if False:",
        "every road that was driven once is closed",
    ),
    M(
        "releases without a fence",
        "server/usecases/roads/section_reservations.py",
        "        if occupancy is None or gone not in occupancy.held or len(occupancy.held) == 1:\n"
        "            return False\n"
        "        held = tuple(section for section in occupancy.held if section != gone)",
        "        if occupancy is None or len(occupancy.held) == 1:\n"
        "            return False\n"
        "        held = tuple(section for section in occupancy.held if section.section_id != section_id)",
        "a late release frees the ground under a vehicle that has come back",
        "tests/server/usecases/orders/test_sections.py",
    ),
    # ------------------------------------------------------------ orders and grants: server to vehicle
    M(
        "expiry forgotten",
        "vehicle_agent/mission/orders.py",
        "    if server_now_ns > order.expires_ns:",
        "    if server_now_ns < 0:",
        "a vehicle that was frozen drives off on an order of minutes ago",
        "tests/vehicle_agent/mission/test_orders.py",
    ),
    M(
        "revisions compared the wrong way",
        "vehicle_agent/mission/orders.py",
        "        return order.revision < known.revision",
        "        return order.revision > known.revision",
        "changed orders are refused, outdated ones followed",
    ),
    M(
        "released grants come back",
        "vehicle_agent/mission/messages.py",
        "    sections = tuple(grant for grant in grants.sections if grant not in state.memory.released)",
        "    sections = grants.sections",
        "a late list of grants lets a vehicle into a section that another one has",
        "tests/vehicle_agent/mission/test_sections.py",
    ),
    M(
        "granted under others",
        "contract/roads/reservation.py",
        "            if self._ground.bits[section_id] & others:",
        "            if self._ground.bits[section_id] & others and count > 1:",
        "two vehicles are let into one section",
    ),
    M(
        "unanswered orders not repeated",
        "server/fleet/sent_messages.py",
        "            if sent_ns is None or now_ns - sent_ns >= REPEAT_AFTER_NS:",
        "            if sent_ns is None:",
        "what is lost once stays lost until the next connection",
        "tests/server/fleet/test_sent_messages.py",
    ),
    M(
        "orders before the backlog",
        "server/fleet/backlog.py",
        "            self._wanted.clear()\n        return bool(self._wanted)\n",
        "            self._wanted.clear()\n        return False\n",
        "an order is made from what the vehicle has long left behind",
        "tests/server/fleet/test_backlog.py",
    ),
    M(
        "commands executed again",
        "vehicle_agent/mission/messages.py",
        "    if command.command_id in state.memory.heard:\n        return state\n",
        "",
        "a repeated resume sets a vehicle in motion that was stopped in between",
    ),
    # ------------------------------------------------------------ sessions
    M(
        "fencing skipped",
        "server/usecases/fleet/vehicle_sessions.py",
        "    if vehicle is None or vehicle.epoch != epoch:\n        raise SessionFenced",
        "    if vehicle is None:\n        raise SessionFenced",
        "frames of a connection long replaced still count",
        "tests/server/usecases/fleet/test_vehicle_events.py",
    ),
    M(
        "an old session's end ends the new one",
        "server/usecases/fleet/vehicle_sessions.py",
        "    if vehicle is None or vehicle.epoch != epoch or not vehicle.connected:",
        "    if vehicle is None or not vehicle.connected:",
        "a vehicle that is connected gets no road any more",
        "tests/server/usecases/fleet/test_vehicle_events.py",
    ),
    # ------------------------------------------------------------ bookings and plans
    M(
        "keys not looked up",
        "server/usecases/rides/rides.py",
        "    if request.idempotency_key is None:\n        return None\n",
        "    if request.party:\n        return None\n",
        "a repeated booking fails",
    ),
    M(
        "keys not stored",
        "server/usecases/rides/rides.py",
        "        idempotency_key=request.idempotency_key,\n        arrive_before=closes,",
        "        idempotency_key=None,\n        arrive_before=closes,",
        "a repeated booking is a second ride",
    ),
    M(
        "boarded elsewhere, fetched all the same",
        "server/usecases/rides/boarding.py",
        "    if not expected:\n        for other",
        "    if False:\n        for other",
        "two vehicles come for one party",
        "tests/server/usecases/rides/test_ride_events.py",
    ),
    M(
        "answered without a commit",
        "server/store/writing/writer.py",
        "            transaction.commit()",
        "            transaction.rollback()",
        "bookings that were acknowledged are gone after a crash",
    ),
    M(
        "half a transaction remembered",
        "server/store/writing/writer.py",
        "            self._memory.take_back(mark)\n",
        "            pass\n",
        "the fleet is dispatched by what was rolled back",
        "tests/server/store/test_transactions.py",
    ),
    # ------------------------------------------------------------ standing tasks
    M(
        "failed tasks not repeated",
        "server/supervision/supervisor.py",
        "                if pause_s is None:\n                    return",
        "                return",
        "after a full disk nothing is dispatched any more",
    ),
    M(
        "held back with a party aboard",
        "server/usecases/orders/orders.py",
        "    if not at_rest or first.alight or first.not_before is None",
        "    if not at_rest or first.not_before is None",
        "a party waits in a resting shuttle for one that boards in an hour",
        "tests/server/usecases/orders/test_orders.py",
    ),
    M(
        "a lease of a wrong clock",
        "server/store/leases.py",
        "        is_live = now < row.expires_at <= now + timedelta(seconds=CLOCKS_APART * seconds)",
        "        is_live = now < row.expires_at",
        "after the clock is set right nothing is dispatched for as long as it was wrong",
        "tests/server/store/test_records.py",
    ),
)
