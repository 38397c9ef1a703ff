"""The methods of /ws/developer."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

import msgspec

from server.api.services import Services
from server.api.sockets.json_rpc import Method
from server.domain.fleet.vehicles import VehicleCommand
from server.domain.rides.rides import Ride, RideState
from server.domain.roads.stops import CampusStop
from server.live.projection import ride_scene
from server.live.scene import RideScene, VehicleScene
from server.usecases.fleet import campus, vehicle_commands
from server.usecases.ports.unit_of_work import UnitOfWork

Topic = Literal["vehicles", "rides", "events"]
VehicleName = Annotated[str, msgspec.Meta(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9._@:-]+$")]
StopName = Annotated[str, msgspec.Meta(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f]+$")]


class NoParams(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    pass


class ListRides(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """states: all when left out."""

    states: list[RideState] | None = None
    limit: Annotated[int, msgspec.Meta(ge=1, le=500)] = 100


class SendToStop(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    vehicle_id: VehicleName
    stop_id: StopName


class VehicleParams(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    vehicle_id: VehicleName


class Topics(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    topics: Annotated[list[Topic], msgspec.Meta(min_length=1, max_length=3)]


@dataclass(slots=True)
class Subscriptions:
    """The topics that this connection has subscribed to."""

    topics: set[Topic] = field(default_factory=set)


class DeveloperMethods:
    """The method table of one connection; `name` is the token's name, for the record."""

    def __init__(self, services: Services, name: str, subscriptions: Subscriptions) -> None:
        self._services, self._by, self._subscriptions = services, f"developer:{name}", subscriptions

    def table(self) -> dict[str, Method]:
        return {
            "list_vehicles": Method(NoParams, "read", self._list_vehicles),
            "list_stops": Method(NoParams, "read", self._list_stops),
            "list_rides": Method(ListRides, "read", self._list_rides),
            "send_to_stop": Method(SendToStop, "drive", self._send_to_stop),
            "pause": Method(VehicleParams, "drive", self._pause),
            "resume": Method(VehicleParams, "drive", self._resume),
            "subscribe": Method(Topics, "read", self._subscribe),
            "unsubscribe": Method(Topics, "read", self._unsubscribe),
        }

    async def _list_vehicles(self, _: NoParams) -> list[VehicleScene]:
        vehicles = self._services.feed.board.vehicles
        return [scene for _, (_, scene) in sorted(vehicles.items())]

    async def _list_stops(self, _: NoParams) -> tuple[CampusStop, ...]:
        return await self._services.transactions.read(campus.stops)

    async def _list_rides(self, params: ListRides) -> list[RideScene]:
        def work(uow: UnitOfWork) -> tuple[Ride, ...]:
            return uow.views.rides(states=params.states, limit=params.limit)

        return [ride_scene(ride) for ride in await self._services.transactions.read(work)]

    async def _send_to_stop(self, params: SendToStop) -> dict[str, object]:
        plan = await vehicle_commands.send(
            self._services.transactions, params.vehicle_id, params.stop_id, self._by
        )
        visit = next(visit for visit in reversed(plan.visits) if visit.stop_id == params.stop_id)
        return {"visit_id": visit.visit_id, "plan_version": plan.version, "eta": visit.eta}

    async def _pause(self, params: VehicleParams) -> dict[str, str]:
        return _receipt(
            await vehicle_commands.pause(self._services.transactions, params.vehicle_id, self._by)
        )

    async def _resume(self, params: VehicleParams) -> dict[str, str]:
        return _receipt(
            await vehicle_commands.resume(self._services.transactions, params.vehicle_id, self._by)
        )

    async def _subscribe(self, params: Topics) -> list[str]:
        self._subscriptions.topics.update(params.topics)
        return sorted(self._subscriptions.topics)

    async def _unsubscribe(self, params: Topics) -> list[str]:
        self._subscriptions.topics.difference_update(params.topics)
        return sorted(self._subscriptions.topics)


def _receipt(command: VehicleCommand) -> dict[str, str]:
    return {"command_id": command.command_id, "state": command.state}
