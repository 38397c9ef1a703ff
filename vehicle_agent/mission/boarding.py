"""Boarding and alighting by code, tap or seat sensor, while the vehicle stands with open doors."""

import msgspec

from contract.wire.messages import (
    BoardedHow,
    CodeRefused,
    DestinationRequested,
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

BoardingResult = tuple[MissionMemory, tuple[VehicleEvent, ...]]


class SeatState(msgspec.Struct, frozen=True):
    """The seat mats since the doors opened.

    occupied   seats in use at the last count
    owed       seats that parties boarded by code or tap will still take
    leaving    seats that parties alighted by code or tap will still leave
    unclaimed  seats filled by no known party yet; vacated: seats emptied by no known party yet
    """

    occupied: int = 0
    owed: int = 0
    leaving: int = 0
    unclaimed: int = 0
    vacated: int = 0


def riders_to_board(visit: Visit | None, memory: MissionMemory) -> tuple[RiderTask, ...]:
    """Parties that may still board at this visit."""
    if visit is None:
        return ()
    aboard = {rider.ride_id for rider in memory.aboard}
    return tuple(r for r in visit.board if r.ride_id not in aboard and r.ride_id not in memory.settled)


def riders_to_alight(visit: Visit | None, memory: MissionMemory) -> tuple[RiderTask, ...]:
    """Parties aboard that should alight here; at an unplanned stop (None), all of them."""
    if visit is None:
        return memory.aboard
    here = {rider.ride_id for rider in visit.alight}
    return tuple(rider for rider in memory.aboard if rider.ride_id in here)


def board(memory: MissionMemory, rider: RiderTask, how: BoardedHow) -> BoardingResult:
    memory = msgspec.structs.replace(memory, aboard=(*memory.aboard, rider))
    return memory, (RiderBoarded(rider.ride_id, how),)


def alight(memory: MissionMemory, ride_id: str, how: BoardedHow) -> BoardingResult:
    memory = msgspec.structs.replace(
        memory,
        aboard=tuple(rider for rider in memory.aboard if rider.ride_id != ride_id),
        settled=remembered(memory.settled, ride_id),
        overdue=tuple(other for other in memory.overdue if other != ride_id),
    )
    return memory, (RiderAlighted(ride_id, how),)


def take_code(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, code: str, doors_open: bool
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    """Boards or alights the party of a code; any other code is refused."""
    if doors_open and code:
        for rider in riders_to_board(visit, memory):
            if rider.code == code:
                memory, events = board(memory, rider, "code")
                return memory, _with_boarded(seats, rider.party), events
        for rider in riders_to_alight(visit, memory):
            if rider.code == code:
                memory, events = alight(memory, rider.ride_id, "code")
                return memory, _with_alighted(seats, rider.party), events
    return memory, seats, (CodeRefused(visit.visit_id if visit else ""),)


def take_destination(
    memory: MissionMemory, visit_id: str, code: str, stop_id: str
) -> DestinationRequested | CodeRefused:
    """What a party aboard asks the server for: the party of the code, or without one the only party aboard.

    stop_id "" for a stop that the map does not have: refused, like a code of no party.
    """
    riders = [rider for rider in memory.aboard if not code or rider.code == code]
    if len(riders) != 1 or not stop_id:
        return CodeRefused(visit_id)
    return DestinationRequested(riders[0].ride_id, stop_id)


def take_tap(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, message: PassengerTap, doors_open: bool
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    """Boards or alights a ride by a tap on the phone; each tap is answered once."""
    if message.tap_id in memory.heard:
        return memory, seats, ()
    memory = msgspec.structs.replace(memory, heard=remembered(memory.heard, message.tap_id))
    events: tuple[VehicleEvent, ...] = ()
    aboard = next((rider for rider in memory.aboard if rider.ride_id == message.ride_id), None)
    reason = "" if doors_open else "the shuttle does not stand with open doors"
    if not reason and message.kind == "board" and aboard is None:
        rider = next((r for r in riders_to_board(visit, memory) if r.ride_id == message.ride_id), None)
        if rider is None:
            reason = "this ride does not board at this stop"
        else:
            memory, events = board(memory, rider, "tap")
            seats = _with_boarded(seats, rider.party)
    elif not reason and message.kind == "alight":
        if aboard is None:
            reason = "this ride is not aboard"
        else:
            memory, events = alight(memory, message.ride_id, "tap")
            seats = _with_alighted(seats, aboard.party)
    return memory, seats, (*events, TapAnswered(message.tap_id, message.ride_id, not reason, reason))


def take_seat_count(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, occupied: int, doors_open: bool
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    """Takes a seat count: more people than accounted for board the next party that fits, fewer alight one."""
    change = occupied - seats.occupied
    seats = msgspec.structs.replace(seats, occupied=occupied)
    if not doors_open or change == 0:
        return memory, seats, ()
    if change > 0:
        return _seats_filled(memory, seats, visit, change)
    return _seats_emptied(memory, seats, visit, -change)


def _seats_filled(
    memory: MissionMemory, seats: SeatState, visit: Visit | None, people: int
) -> tuple[MissionMemory, SeatState, tuple[VehicleEvent, ...]]:
    known = min(people, seats.owed)
    seats = msgspec.structs.replace(
        seats, owed=seats.owed - known, unclaimed=seats.unclaimed + people - known
    )
    events: tuple[VehicleEvent, ...] = ()
    for rider in riders_to_board(visit, memory):
        if rider.party <= seats.unclaimed:
            memory, boarded = board(memory, rider, "sensor")
            events += boarded
            seats = msgspec.structs.replace(seats, unclaimed=seats.unclaimed - rider.party)
    return memory, seats, events


def _seats_emptied(
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
    candidates = riders_to_alight(visit, memory)
    if visit is None and len({rider.party for rider in candidates}) < len(candidates):
        # At an unplanned stop the seat count cannot tell two parties of the same size apart.
        return memory, seats, ()
    for rider in candidates:
        fits = rider.party == seats.vacated if visit is None else rider.party <= seats.vacated
        if fits:
            memory, alighted = alight(memory, rider.ride_id, "sensor")
            events += alighted
            seats = msgspec.structs.replace(seats, vacated=seats.vacated - rider.party)
    return memory, seats, events


def told_again(memory: MissionMemory, visit: Visit) -> tuple[VehicleEvent, ...]:
    """What an order shows that the server does not know: it asks for what has happened already.

    Its database is then older than this memory. The server takes each of these once, so a repeat is harmless.
    """
    aboard = {rider.ride_id for rider in memory.aboard}
    boarded = tuple(RiderBoarded(rider.ride_id, "sensor") for rider in visit.board if rider.ride_id in aboard)
    gone = tuple(RiderNoShow(rider.ride_id) for rider in visit.board if rider.ride_id in memory.settled)
    alighted = tuple(
        RiderAlighted(rider.ride_id, "sensor") for rider in visit.alight if rider.ride_id in memory.settled
    )
    return boarded + gone + alighted


def close_visit(memory: MissionMemory, visit: Visit | None) -> BoardingResult:
    """Ends the dwell: each missing party is a no-show, and each party that stayed is reported once."""
    if visit is None:
        return memory, ()
    missing = riders_to_board(visit, memory)
    remaining = tuple(
        rider for rider in riders_to_alight(visit, memory) if rider.ride_id not in memory.overdue
    )
    settled, overdue = memory.settled, memory.overdue
    for rider in missing:
        settled = remembered(settled, rider.ride_id)
    for rider in remaining:
        overdue = remembered(overdue, rider.ride_id)
    if missing or remaining:
        memory = msgspec.structs.replace(memory, settled=settled, overdue=overdue)
    no_shows: tuple[VehicleEvent, ...] = tuple(RiderNoShow(rider.ride_id) for rider in missing)
    return memory, no_shows + tuple(RiderDidNotAlight(rider.ride_id) for rider in remaining)


def _with_boarded(seats: SeatState, party: int) -> SeatState:
    """After a party boarded by code or tap: it may sit already, else its seats are owed."""
    sitting = min(party, seats.unclaimed)
    return msgspec.structs.replace(
        seats, unclaimed=seats.unclaimed - sitting, owed=seats.owed + party - sitting
    )


def _with_alighted(seats: SeatState, party: int) -> SeatState:
    """After a party alighted by code or tap: it may have stood up already, else its seats will empty."""
    alighted = min(party, seats.vacated)
    return msgspec.structs.replace(
        seats, vacated=seats.vacated - alighted, leaving=seats.leaving + party - alighted
    )
