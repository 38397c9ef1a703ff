"""Dynamic dial-a-ride instances as JSON (Berbeglia, Cordeau, Laporte 2012).

Each request has the time at which it becomes known.
"""

from typing import Annotated

import msgspec
import numpy as np

from campusloop.studies.instances.instance import Instance, InstanceBroken, checked

_Count = Annotated[int, msgspec.Meta(ge=1)]


class _Place(msgspec.Struct):
    x_coord: float
    y_coord: float


class _Facts(msgspec.Struct):
    number_of_vehicles: _Count
    vehicle_capacity: _Count
    max_ride_time: float
    max_route_time: float
    depot_location: _Place
    planing_horizon: float
    instance: str = ""


class _Request(msgspec.Struct):
    id: int
    pickup_location: _Place
    delivery_location: _Place
    pickup_lower_tw: float
    pickup_upper_tw: float
    pickup_service_time: float
    delivery_lower_tw: float
    delivery_upper_tw: float
    delivery_service_time: float
    load: _Count
    arrival_time: float


class _File(msgspec.Struct):
    static_info: _Facts
    requests: list[_Request]


def instance_from_json(name: str, text: str) -> Instance:
    """The instance. A pickup's node number is its id, its drop-off's is n more. Raises InstanceBroken."""
    try:
        file = msgspec.json.decode(text, type=_File)
    except (msgspec.ValidationError, msgspec.DecodeError) as error:
        raise InstanceBroken(f"{name}: {error}") from error
    requests = sorted(file.requests, key=lambda request: request.id)
    if [request.id for request in requests] != list(range(1, len(requests) + 1)) or not requests:
        raise InstanceBroken(f"{name}: request ids are not 1..n; a request is missing or occurs twice")
    facts = file.static_info
    n = len(requests)
    sides = [r.pickup_location for r in requests] + [r.delivery_location for r in requests]
    pickups = np.arange(1, n + 1)
    return checked(
        Instance(
            name=name,
            vehicles=facts.number_of_vehicles,
            capacity=facts.vehicle_capacity,
            duration_max=facts.max_route_time,
            ride_max=facts.max_ride_time,
            nodes=np.arange(2 * n + 1),
            xy=np.array([[place.x_coord, place.y_coord] for place in (facts.depot_location, *sides)]),
            service=np.array(
                [0.0]
                + [r.pickup_service_time for r in requests]
                + [r.delivery_service_time for r in requests]
            ),
            load=np.array([0] + [r.load for r in requests] + [-r.load for r in requests]),
            early=np.array(
                [0.0] + [r.pickup_lower_tw for r in requests] + [r.delivery_lower_tw for r in requests]
            ),
            late=np.array(
                [facts.planing_horizon]
                + [r.pickup_upper_tw for r in requests]
                + [r.delivery_upper_tw for r in requests]
            ),
            pairs=np.column_stack([pickups, pickups + n]),
            revealed=np.array([r.arrival_time for r in requests]),
        )
    )
