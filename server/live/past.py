"""The fleet in the past, as browsers get it: positions in columns, and what happened as marks in time.

Times are milliseconds since the Unix epoch by the server's clock, positions in the map frame.
"""

from collections.abc import Iterable, Sequence
from typing import Literal

import msgspec

from contract.wire.messages import (
    Blocked,
    DriveMode,
    FaultRaised,
    ModeChanged,
    SeatButtonPressed,
    VisitChanged,
)
from server.domain.fleet.vehicles import Vehicle
from server.domain.instants import ms_of
from server.domain.record.events import RecordedEvent, ServerEvent
from server.domain.record.incidents import Incident
from server.domain.record.runs import Run
from server.domain.rides.rides import Ride
from server.usecases.ports.past import PastPosition
from server.usecases.record.server_events import BRAKING_EVENT

MarkKind = Literal[
    "stop",
    "takeover",
    "minimal_risk_stop",
    "braking",
    "blocked",
    "fault",
    "seat_button",
    "incident",
    "intervention",
    "note",
    "recording",
]
# Of the events of vehicles and of the server that become marks.
EVENT_KINDS = ("mode_changed", "blocked", "fault_raised", "seat_button_pressed")
STOP_KINDS = ("visit_changed",)
# What operators mark of a recording, with its name or their note.
RECORDING_MARKS: dict[str, MarkKind] = {
    "vehicle.mark": "note",
    "vehicle.start_recording": "recording",
    "vehicle.stop_recording": "recording",
}
INTERVENTIONS = (
    "vehicle.hold",
    "vehicle.resume",
    "vehicle.stop_now",
    "vehicle.recalled",
    "vehicle.returned",
    "vehicle.evacuated",
    "vehicle.reassigned",
    "vehicle.sent",
    "vehicle.placed",
    *RECORDING_MARKS,
    BRAKING_EVENT,
)
# The gate says by such a fault why it brakes.
BRAKING = "gate_braking_"
_MODE_MARKS: dict[DriveMode, MarkKind] = {"manual": "takeover", "minimal_risk": "minimal_risk_stop"}


class Track(msgspec.Struct, frozen=True):
    """Where one vehicle was: columns of equal length, one entry a position, oldest first."""

    vehicle_id: str
    at_ms: list[int]
    x_m: list[float]
    y_m: list[float]
    yaw_rad: list[float]
    speed_mps: list[float]
    mode: list[DriveMode]
    battery_ratio: list[float]


class FleetPositions(msgspec.Struct, frozen=True):
    """Every position of [from_ms, to_ms), at most one each step. Ask on from `to_ms`."""

    from_ms: int
    to_ms: int
    tracks: list[Track]


class Mark(msgspec.Struct, frozen=True):
    """Something that happened. detail: a stable code, e.g. of a fault; by: who did it.

    text  an operator's note, or the name of a recording
    """

    at_ms: int
    kind: MarkKind
    vehicle_id: str
    stop_id: str = ""
    ride_id: str = ""
    detail: str = ""
    by: str = ""
    text: str = ""


class PastVehicle(msgspec.Struct, frozen=True):
    vehicle_id: str
    name: str
    seats: int


class PastRide(msgspec.Struct, frozen=True):
    """A ride with a vehicle. state: a `RideState`; boarded_ms, ended_ms: 0 before that happens."""

    ride_id: str
    ride_code: str
    state: str
    vehicle_id: str
    from_stop: str
    to_stop: str
    party: int
    requested_ms: int
    boarded_ms: int
    ended_ms: int


class PastRun(msgspec.Struct, frozen=True):
    """A recording of one vehicle, which has its own replay. to_ms: when its last segment had come."""

    vehicle_id: str
    boot_id: str
    from_ms: int
    to_ms: int


class FleetPast(msgspec.Struct, frozen=True):
    """What happened in [from_ms, to_ms), oldest first. is_cut: there was more than is told."""

    from_ms: int
    to_ms: int
    vehicles: list[PastVehicle]
    marks: list[Mark]
    rides: list[PastRide]
    runs: list[PastRun]
    is_cut: bool


def fleet_positions(
    found: Sequence[PastPosition], from_ms: int, to_ms: int, step_ms: int, is_cut: bool
) -> FleetPositions:
    """is_cut: the last of `found` is where the store stopped, so only what lies before it is whole."""
    if is_cut and found:
        to_ms = max(ms_of(found[-1].at), from_ms + 1)
    tracks: dict[str, Track] = {}
    for one in found:
        at_ms = ms_of(one.at)
        if at_ms >= to_ms:
            break
        track = tracks.get(one.vehicle_id)
        if track is None:
            track = tracks[one.vehicle_id] = Track(one.vehicle_id, [], [], [], [], [], [], [])
        elif at_ms < track.at_ms[-1] + step_ms:
            continue
        track.at_ms.append(at_ms)
        track.x_m.append(round(one.x_m, 2))
        track.y_m.append(round(one.y_m, 2))
        track.yaw_rad.append(round(one.yaw_rad, 3))
        track.speed_mps.append(round(one.speed_mps, 2))
        track.mode.append(msgspec.convert(one.mode, DriveMode))
        track.battery_ratio.append(round(one.battery_ratio, 3))
    return FleetPositions(from_ms, to_ms, [tracks[vehicle_id] for vehicle_id in sorted(tracks)])


def marks(
    events: Iterable[RecordedEvent], incidents: Iterable[Incident], said: Iterable[ServerEvent]
) -> list[Mark]:
    """In order of time."""
    found = [mark for event in events if (mark := _mark_of_event(event)) is not None]
    found += [
        Mark(
            ms_of(one.opened_at),
            "incident",
            one.vehicle_id or "",
            ride_id=one.ride_id or "",
            detail=one.kind.value,
        )
        for one in incidents
    ]
    found += [_mark_of_server_event(one) for one in said]
    return sorted(found, key=lambda mark: (mark.at_ms, mark.vehicle_id, mark.kind, mark.detail))


def _mark_of_server_event(event: ServerEvent) -> Mark:
    at_ms, kind = ms_of(event.happened_at), RECORDING_MARKS.get(event.name)
    if event.name == BRAKING_EVENT:
        return Mark(at_ms, "braking", event.subject, detail=f"braking_by_{event.by}")
    if kind is None:
        return Mark(at_ms, "intervention", event.subject, detail=event.name, by=event.by)
    return Mark(at_ms, kind, event.subject, detail=event.name, by=event.by, text=event.detail)


def past_vehicle(vehicle: Vehicle) -> PastVehicle:
    return PastVehicle(vehicle.vehicle_id, vehicle.name, vehicle.seats)


def past_ride(ride: Ride) -> PastRide:
    return PastRide(
        ride_id=ride.ride_id,
        ride_code=ride.ride_code,
        state=str(ride.state),
        vehicle_id=ride.vehicle_id or "",
        from_stop=ride.from_stop,
        to_stop=ride.to_stop,
        party=ride.party,
        requested_ms=ms_of(ride.requested_at),
        boarded_ms=ms_of(ride.boarded_at),
        ended_ms=ms_of(ride.ended_at),
    )


def past_run(run: Run) -> PastRun:
    to_ms = max(ms_of(segment.received_at) for segment in run.segments)
    return PastRun(run.vehicle_id, run.boot_id, ms_of(run.started_at), to_ms)


def _mark_of_event(event: RecordedEvent) -> Mark | None:
    """None for what is no news: a visit that has ended, a mode as it should be, something that is over."""
    at_ms, body = event.received_ns // 1_000_000, event.body
    match body:
        case VisitChanged(state="under_way") if body.stop_id:
            return Mark(at_ms, "stop", event.vehicle_id, stop_id=body.stop_id)
        case ModeChanged() if body.mode in _MODE_MARKS:
            return Mark(at_ms, _MODE_MARKS[body.mode], event.vehicle_id, detail=body.reason or "")
        case Blocked(cleared=False):
            return Mark(at_ms, "blocked", event.vehicle_id)
        case FaultRaised(cleared=False):
            kind: MarkKind = "braking" if body.fault.code.startswith(BRAKING) else "fault"
            return Mark(at_ms, kind, event.vehicle_id, detail=body.fault.code)
        case SeatButtonPressed():
            return Mark(at_ms, "seat_button", event.vehicle_id)
        case _:
            return None
