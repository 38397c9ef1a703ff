"""Who is aboard is what the vehicle says: code, tap or seat sensor, while it stands with open doors."""

import msgspec

from contract.wire.messages import (
    BoardedHow,
    CodeRefused,
    PassengerTap,
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    RiderNoShow,
    RiderTask,
    TapAnswered,
    VehicleEvent,
    Visit,
)
from vehicle_agent.mission.memory import MissionMemory, remembered

Happened = tuple[MissionMemory, tuple[VehicleEvent, ...]]


class SeatState(msgspec.Struct, frozen=True):
    """The seat mats since the doors opened.

    occupied   seats taken at the last word
    owed       seats that parties boarded by code or tap will still take
    leaving    seats that parties alighted by code or tap will still leave
    unclaimed  seats taken by nobody known yet; vacated: seats left by nobody known yet
    """

    occupied: int = 0
    owed: int = 0
    leaving: int = 0
    unclaimed: int = 0
    vacated: int = 0


def waiting(visit: Visit | None, memory: MissionMemory) -> tuple[RiderTask, ...]:
    """Parties that may still board at this visit."""
    if visit is None:
        return ()
    aboard = {rider.ride_id for rider in memory.aboard}
    return tuple(r for r in visit.board if r.ride_id not in aboard and r.ride_id not in memory.settled)


def due(visit: Visit | None, memory: MissionMemory) -> tuple[RiderTask, ...]:
    """Parties aboard that should alight here; at a stop nobody planned (None) that is anybody."""
    if visit is None:
        return memory.aboard
    here = {rider.ride_id for rider in visit.alight}
    return tuple(rider for rider in memory.aboard if rider.ride_id in here)


def board(memory: MissionMemory, rider: RiderTask, how: BoardedHow) -> Happened:
    memory = msgspec.structs.replace(memory, aboard=(*memory.aboard, rider))
    return memory, (RiderBoarded(rider.ride_id, how),)


def alight(memory: MissionMemory, ride_id: str, how: BoardedHow) -> Happened:
    memory = msgspec.structs.replace(
        memory,
        aboard=tuple(rider for rider in memory.aboard if rider.ride_id != ride_id),
        settled=remembered(memory.settled, ride_id),
        overdue=tuple(other for other in memory.overdue if other != ride_id),
    )
    return memory, (RiderAlighted(ride_id, how),)


def type_code(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, code: str, doors_open: bool
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    """A code boards its party, or lets one aboard alight; any other code is refused."""
    if doors_open and code:
        for rider in waiting(visit, memory):
            if rider.code == code:
                memory, events = board(memory, rider, "code")
                return memory, _claimed(seats, rider.party), events
        for rider in due(visit, memory):
            if rider.code == code:
                memory, events = alight(memory, rider.ride_id, "code")
                return memory, _left(seats, rider.party), events
    return memory, seats, (CodeRefused(visit.visit_id if visit else ""),)


def tap(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, word: PassengerTap, doors_open: bool
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    """A tap on the phone, answered once."""
    if word.tap_id in memory.heard:
        return memory, seats, ()
    memory = msgspec.structs.replace(memory, heard=remembered(memory.heard, word.tap_id))
    events: tuple[VehicleEvent, ...] = ()
    aboard = next((rider for rider in memory.aboard if rider.ride_id == word.ride_id), None)
    reason = "" if doors_open else "the shuttle does not stand with open doors"
    if not reason and word.kind == "board" and aboard is None:
        rider = next((r for r in waiting(visit, memory) if r.ride_id == word.ride_id), None)
        if rider is None:
            reason = "this ride does not board at this stop"
        else:
            memory, events = board(memory, rider, "tap")
            seats = _claimed(seats, rider.party)
    elif not reason and word.kind == "alight":
        if aboard is None:
            reason = "this ride is not aboard"
        else:
            memory, events = alight(memory, word.ride_id, "tap")
            seats = _left(seats, aboard.party)
    return memory, seats, (*events, TapAnswered(word.tap_id, word.ride_id, not reason, reason))


def sit(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, occupied: int, doors_open: bool
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    """A seat count: people more than accounted for board the next party that fits, fewer let one alight."""
    change = occupied - seats.occupied
    seats = msgspec.structs.replace(seats, occupied=occupied)
    if not doors_open or change == 0:
        return memory, seats, ()
    if change > 0:
        return _sat_down(memory, seats, visit, change)
    return _stood_up(memory, seats, visit, -change)


def _sat_down(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, people: int
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    known = min(people, seats.owed)
    seats = msgspec.structs.replace(
        seats, owed=seats.owed - known, unclaimed=seats.unclaimed + people - known
    )
    events: tuple[VehicleEvent, ...] = ()
    for rider in waiting(visit, memory):
        if rider.party <= seats.unclaimed:
            memory, boarded = board(memory, rider, "sensor")
            events += boarded
            seats = msgspec.structs.replace(seats, unclaimed=seats.unclaimed - rider.party)
    return memory, seats, events


def _stood_up(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, people: int
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    known = min(people, seats.leaving)
    strangers = min(people - known, seats.unclaimed)
    seats = msgspec.structs.replace(
        seats,
        leaving=seats.leaving - known,
        unclaimed=seats.unclaimed - strangers,
        vacated=seats.vacated + people - known - strangers,
    )
    events: tuple[VehicleEvent, ...] = ()
    candidates = due(visit, memory)
    if visit is None and len({rider.party for rider in candidates}) < len(candidates):
        # At a stop nobody planned, the seat count cannot tell two parties of one size apart.
        return memory, seats, ()
    for rider in candidates:
        fits = rider.party == seats.vacated if visit is None else rider.party <= seats.vacated
        if fits:
            memory, gone = alight(memory, rider.ride_id, "sensor")
            events += gone
            seats = msgspec.structs.replace(seats, vacated=seats.vacated - rider.party)
    return memory, seats, events


def close_list(memory: MissionMemory, visit: Visit | None) -> Happened:
    """The end of the dwell: who did not come, and who did not go, each told once."""
    if visit is None:
        return memory, ()
    missing = waiting(visit, memory)
    staying = tuple(rider for rider in due(visit, memory) if rider.ride_id not in memory.overdue)
    settled, overdue = memory.settled, memory.overdue
    for rider in missing:
        settled = remembered(settled, rider.ride_id)
    for rider in staying:
        overdue = remembered(overdue, rider.ride_id)
    if missing or staying:
        memory = msgspec.structs.replace(memory, settled=settled, overdue=overdue)
    no_shows: tuple[VehicleEvent, ...] = tuple(RiderNoShow(rider.ride_id) for rider in missing)
    return memory, no_shows + tuple(RiderDidNotAlight(rider.ride_id) for rider in staying)


def _claimed(seats: SeatState, party: int) -> SeatState:
    """A party boarded by word: it may sit already, else its seats are owed."""
    sitting = min(party, seats.unclaimed)
    return msgspec.structs.replace(
        seats, unclaimed=seats.unclaimed - sitting, owed=seats.owed + party - sitting
    )


def _left(seats: SeatState, party: int) -> SeatState:
    """A party alighted by word: it may have stood up already, else its seats will empty."""
    gone = min(party, seats.vacated)
    return msgspec.structs.replace(seats, vacated=seats.vacated - gone, leaving=seats.leaving + party - gone)
