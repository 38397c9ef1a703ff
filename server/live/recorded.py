"""A recorded run as scenes, in the shape that screens know from live."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from contract.runlog.reader import RunLogError, reports
from contract.wire.messages import Status
from server.domain.rides import Ride
from server.domain.runs import Run
from server.domain.vehicles import Vehicle
from server.live.projection import ride_scene, vehicle_in_status
from server.live.scene import Scene, VehicleScene

MS_NS = 1_000_000


def recorded_scenes(
    run: Run,
    vehicle: Vehicle,
    rides: Mapping[str, Ride],
    segments: tuple[Path, ...],
    from_ms: int,
    to_ms: int,
    step_ms: int,
    limit: int,
) -> tuple[Scene, ...]:
    """One scene at most each step_ms of [from_ms, to_ms), from the vehicle's own reports.

    rides   those that may have been aboard, by id
    A damaged or cut segment ends where it is no longer sound.
    """
    scenes: list[Scene] = []
    next_ms = from_ms
    for log_ns, status in _reports(segments, from_ms * MS_NS, to_ms * MS_NS):
        at_ms = log_ns // MS_NS
        if at_ms < next_ms:
            continue
        scenes.append(_scene(run, vehicle, rides, at_ms, status))
        if len(scenes) == limit:
            break
        next_ms = at_ms + step_ms
    return tuple(scenes)


def _reports(segments: tuple[Path, ...], from_ns: int, to_ns: int) -> Iterator[tuple[int, Status]]:
    for path in segments:
        try:
            yield from reports(path, from_ns, to_ns)
        except RunLogError as error:
            if error.code not in ("truncated", "damaged"):
                raise


def _scene(run: Run, vehicle: Vehicle, rides: Mapping[str, Ride], at_ms: int, status: Status) -> Scene:
    aboard = [rides[ride_id] for ride_id in status.aboard if ride_id in rides]
    facts = VehicleScene(
        vehicle_id=vehicle.vehicle_id,
        name=vehicle.name,
        seats=vehicle.seats,
        connected=True,
        people_aboard=sum(ride.party for ride in aboard),
    )
    return Scene(
        at_ms=at_ms,
        campus_id=run.campus_id,
        map_version=run.map_version,
        vehicles=(vehicle_in_status(facts, status, at_ms),),
        rides=tuple(ride_scene(ride, state="aboard") for ride in aboard),
    )
