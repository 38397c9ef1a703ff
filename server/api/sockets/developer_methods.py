"""The methods of /ws/developer."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import msgspec

from server.api.commands import Command
from server.api.paging import cursor_of, microseconds_of, moment_of, of_kinds, position_of
from server.api.security.access import Actor, now_ns
from server.api.services import Services
from server.api.sockets.developer_messages import (
    CommandReceipt,
    ListRides,
    NoParams,
    RidesPage,
    SendToStop,
    SentVisit,
    Topic,
    Topics,
    VehicleCommandParams,
)
from server.api.sockets.json_rpc import Method
from server.domain.fleet.vehicles import VehicleCommand
from server.domain.planning.outlooks import RideOutlook
from server.domain.record.audit import AuditAction, Caller
from server.domain.rides.rides import Ride
from server.domain.roads.stops import CampusStop
from server.live.projection import ride_scene
from server.live.scene import VehicleScene
from server.live.viewer import EverythingScope, Viewer
from server.usecases.fleet import campus, vehicle_commands
from server.usecases.planning.outlooks import outlooks_of
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.dry_run import roll_back

Params = SendToStop | VehicleCommandParams


@dataclass(slots=True)
class Subscriptions:
    """The topics that this connection has subscribed to; for vehicles and rides, what it has been sent."""

    topics: set[Topic] = field(default_factory=set)
    viewers: dict[Topic, Viewer] = field(default_factory=dict)

    def add(self, topics: list[Topic]) -> None:
        """A topic that is subscribed to again begins with a snapshot again."""
        self.topics.update(topics)
        for topic in topics:
            if topic != "events":
                self.viewers[topic] = Viewer(EverythingScope())

    def remove(self, topics: list[Topic]) -> None:
        self.topics.difference_update(topics)
        for topic in topics:
            self.viewers.pop(topic, None)


class DeveloperMethods:
    """The method table of one connection; `actor` is the token's."""

    def __init__(
        self, services: Services, actor: Actor, subscriptions: Subscriptions, address: str = ""
    ) -> None:
        self._services, self._actor, self._subscriptions = services, actor, subscriptions
        self._caller = Caller(actor.kind, actor.name, address)

    def table(self) -> dict[str, Method]:
        return {
            "list_vehicles": Method(NoParams, "read", list[VehicleScene], self._list_vehicles),
            "list_stops": Method(NoParams, "read", list[CampusStop], self._list_stops),
            "list_rides": Method(ListRides, "read", RidesPage, self._list_rides),
            "send_to_stop": Method(SendToStop, "drive", SentVisit, self._send_to_stop),
            "pause": Method(VehicleCommandParams, "drive", CommandReceipt, self._pause),
            "resume": Method(VehicleCommandParams, "drive", CommandReceipt, self._resume),
            "subscribe": Method(Topics, "read", list[Topic], self._subscribe),
            "unsubscribe": Method(Topics, "read", list[Topic], self._unsubscribe),
        }

    async def _list_vehicles(self, _: NoParams) -> list[VehicleScene]:
        vehicles = self._services.feed.board.vehicles
        return [scene for _, (_, scene) in sorted(vehicles.items())]

    async def _list_stops(self, _: NoParams) -> tuple[CampusStop, ...]:
        return await self._services.transactions.read(campus.stops)

    async def _list_rides(self, params: ListRides) -> RidesPage:
        """Raises CursorInvalid."""
        after = None
        if params.cursor is not None:
            moment, ride_id = of_kinds(position_of(params.cursor), int, str)
            after = (moment_of(moment), str(ride_id))

        def work(uow: UnitOfWork) -> tuple[tuple[Ride, ...], Mapping[str, RideOutlook]]:
            listed = uow.views.rides(states=params.states, limit=params.limit + 1, after=after)
            return listed, outlooks_of(uow, listed)

        found, outlooks = await self._services.transactions.read(work)
        scenes = tuple(ride_scene(ride, outlook=outlooks[ride.ride_id]) for ride in found[: params.limit])
        shown = found[: params.limit]
        if len(found) == len(shown):
            return RidesPage(scenes)
        last = shown[-1]
        cursor = cursor_of((microseconds_of(last.requested_at), last.ride_id))
        return RidesPage(scenes, cursor)

    async def _send_to_stop(self, params: SendToStop) -> SentVisit:
        def work(uow: UnitOfWork) -> SentVisit:
            sent = vehicle_commands.send(uow, params.vehicle_id, params.stop_id, self._actor.name)
            return SentVisit(sent.visit.visit_id, sent.plan_version, sent.visit.eta)

        if params.dry_run:
            self._take_try()
            return await roll_back(self._services.transactions, work)
        return await self._command("send_to_stop", params).transact(SentVisit, work)

    async def _pause(self, params: VehicleCommandParams) -> CommandReceipt:
        return await self._command("pause", params).call(
            CommandReceipt,
            lambda transactions: vehicle_commands.pause(transactions, params.vehicle_id, self._actor.name),
            _receipt,
        )

    async def _resume(self, params: VehicleCommandParams) -> CommandReceipt:
        return await self._command("resume", params).transact(
            CommandReceipt,
            lambda uow: _receipt(vehicle_commands.resume(uow, params.vehicle_id, self._actor.name)),
        )

    async def _subscribe(self, params: Topics) -> list[Topic]:
        self._subscriptions.add(params.topics)
        return sorted(self._subscriptions.topics)

    async def _unsubscribe(self, params: Topics) -> list[Topic]:
        self._subscriptions.remove(params.topics)
        return sorted(self._subscriptions.topics)

    def _take_try(self) -> None:
        """Raises TooManyTries."""
        self._services.limits.commands.take(self._actor.account, now_ns(self._services))

    def _command(self, method: str, params: Params) -> Command:
        self._take_try()
        actor, request = self._actor, msgspec.json.encode({"method": method, "params": params})
        return Command(
            self._services.transactions,
            actor.kind,
            actor.name,
            actor.account,
            params.idempotency_key,
            request,
            self._caller,
            AuditAction(method, params.vehicle_id, f"/ws/developer {method}"),
        )


def _receipt(command: VehicleCommand) -> CommandReceipt:
    return CommandReceipt(command.command_id, command.state)
