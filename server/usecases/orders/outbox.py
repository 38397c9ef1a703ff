"""Everything that the server has to send to one vehicle now."""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec

from contract.wire.bounds import INTEGER_MAX
from contract.wire.messages import LATER_KINDS, Command, Grants, Order, PassengerTap
from server.domain.fleet.vehicles import Vehicle, VehicleCommand
from server.domain.instants import ns_of
from server.domain.orders.orders import IssuedOrder, OrderState
from server.usecases.orders.order_payload import expiry_ns, with_codes
from server.usecases.orders.sections import grants_of
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import recordings
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

# An announcement without an end stays until the server takes it down.
UNTIL_ENDED_NS = INTEGER_MAX


@dataclass(frozen=True, slots=True)
class Outbox:
    """order is None when the vehicle follows the newest one already; grants None while it has no order.

    Repeats are harmless to the vehicle; a session may leave out what it has sent already.
    """

    order: Order | None
    grants: Grants | None
    commands: tuple[Command, ...]
    taps: tuple[PassengerTap, ...]


def outbox_of(uow: UnitOfWork, vehicle_id: str, understands: Sequence[str] = LATER_KINDS) -> Outbox:
    """Order, grants, commands and taps, stamped with the vehicle's epoch. Raises VehicleUnknown.

    understands  see `recordings.deliverable`
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    epoch = vehicle.epoch
    order, grants = _driving(uow, vehicle)
    return Outbox(
        order=order,
        grants=grants,
        commands=tuple(
            _command(uow, epoch, command)
            for command in recordings.deliverable(uow, uow.vehicles.pending_commands(vehicle_id), understands)
        ),
        taps=tuple(
            PassengerTap(epoch, tap.tap_id, tap.ride_id, tap.kind)
            for tap in uow.rides.pending_taps(vehicle_id)
        ),
    )


def _command(uow: UnitOfWork, epoch: int, command: VehicleCommand) -> Command:
    """With the other language and the end of the announcement that it says."""
    sent = Command(
        epoch, command.command_id, command.kind, command.text, ns_of(command.made_at), pose_map=command.pose
    )
    announcement = uow.announcements.get(command.announcement_id) if command.announcement_id else None
    if announcement is None:
        return sent
    until_ns = UNTIL_ENDED_NS if announcement.ends_at is None else ns_of(announcement.ends_at)
    return msgspec.structs.replace(sent, text_zh=announcement.text_zh, shown_until_ns=until_ns)


def _driving(uow: UnitOfWork, vehicle: Vehicle) -> tuple[Order | None, Grants | None]:
    issued = uow.orders.current(vehicle.vehicle_id)
    if issued is None or not vehicle.placed or issued.state in (OrderState.DONE, OrderState.REJECTED):
        return None, None
    held = grants_of(uow, vehicle.vehicle_id)
    grants = Grants(vehicle.epoch, issued.order_id, held)
    if vehicle.map_version not in ("", uow.maps.active_version()):
        # It would refuse an order of another map. It goes on with the one that it has, until it changes over.
        return None, grants
    return (_renewed(uow, vehicle, issued, grants), grants)


def _renewed(uow: UnitOfWork, vehicle: Vehicle, issued: IssuedOrder, grants: Grants) -> Order | None:
    """An order that the vehicle has not accepted yet, with what changes between two sendings."""
    if issued.state is not OrderState.ISSUED:
        return None
    renewed = msgspec.structs.replace(
        issued.payload,
        epoch=vehicle.epoch,
        # The same roads, if the map has changed since: else the order would have been withdrawn.
        map_version=uow.network().map_version,
        sections=grants.sections,
        expires_ns=expiry_ns(uow),
    )
    return with_codes(uow, renewed)
