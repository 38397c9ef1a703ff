"""Vehicles: operators see and command them; a vehicle enrols itself."""

import math
from typing import Annotated

from fastapi import APIRouter, Query, Request

from contract.geometry import Pose2
from server.api.commands import (
    AdminCommand,
    DispatchCommand,
    EvacuationCommand,
    MoveCommand,
    PlaceCommand,
    StopCommand,
)
from server.api.formats import StopId, VehicleId
from server.api.interventions.schemas import HoldSeconds
from server.api.paging import ListLimit, Page, paged
from server.api.problems import problems
from server.api.rides.schemas import RideRecord
from server.api.rides.views import ride_record
from server.api.security.access import (
    DRIVER_REFUSALS,
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    SECOND_FACTOR_REFUSALS,
    Client,
    Reader,
    now_ns,
)
from server.api.security.rate_limit import TooManyTries
from server.api.security.request_origin import address_of
from server.api.services import InjectedServices
from server.api.vehicles.schemas import (
    Announcement,
    CodeView,
    CommandView,
    Enrolment,
    NamedPosition,
    NewVehicle,
    Place,
    VehicleDetail,
    VehicleRecord,
    command_view,
    vehicle_detail,
    vehicle_record,
)
from server.domain.errors import (
    EnrolmentCodeUnknown,
    EnrolmentCodeUsed,
    KeyInvalid,
    KeyUnknown,
    NobodyAboard,
    NoRestingPlaceFree,
    SectionsTaken,
    StopUnknown,
    StopUnreachable,
    VehicleMoves,
    VehicleNotConnected,
    VehicleNotPlaced,
    VehicleOutOfService,
    VehicleUnknown,
)
from server.domain.record.audit import AuditAction, Caller
from server.usecases.fleet import vehicle_commands, vehicles
from server.usecases.planning.outlooks import outlook_of
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import audit, identity
from server.usecases.record.dry_run import roll_back
from server.usecases.rides import lost_vehicles
from server.usecases.rides.tickets import secrets_of

router = APIRouter(prefix="/vehicles", tags=["vehicles"])
enrolments = APIRouter(prefix="/enrolments", tags=["vehicles"])

COMMAND = problems(VehicleUnknown, *DRIVER_REFUSALS)
MOVE = problems(VehicleUnknown, *DRIVER_REFUSALS, *SECOND_FACTOR_REFUSALS)


@router.get("", operation_id="list_vehicles", responses=paged(*READER_REFUSALS))
async def list_vehicles(
    services: InjectedServices, _: Reader, page: Page, limit: ListLimit = None
) -> list[VehicleDetail]:
    """By id, retired ones left out."""
    found = await services.transactions.read(
        lambda uow: [vehicle_detail(view, uow.rules) for view in uow.views.vehicles()]
    )
    return page.cut(found, limit, lambda vehicle: (vehicle.vehicle_id,))


@router.get("/{vehicle_id}", operation_id="get_vehicle", responses=problems(VehicleUnknown, *READER_REFUSALS))
async def get_vehicle(vehicle_id: VehicleId, services: InjectedServices, _: Reader) -> VehicleDetail:
    def work(uow: UnitOfWork) -> VehicleDetail:
        view = uow.views.vehicle(vehicle_id)
        if view is None:
            raise VehicleUnknown(f"no vehicle is called {vehicle_id}; see GET /vehicles")
        return vehicle_detail(view, uow.rules)

    return await services.transactions.read(work)


@router.post("/{vehicle_id}/hold", operation_id="hold_vehicle", status_code=202, responses=COMMAND)
async def hold_vehicle(vehicle_id: VehicleId, command: StopCommand, for_s: HoldSeconds = None) -> CommandView:
    """Come to a comfortable stand, until resumed or for a time. See the preview."""
    return await command.call(
        CommandView,
        lambda transactions: vehicle_commands.pause(transactions, vehicle_id, command.by, for_s),
        command_view,
    )


@router.post("/{vehicle_id}/resume", operation_id="resume_vehicle", status_code=202, responses=MOVE)
async def resume_vehicle(vehicle_id: VehicleId, command: MoveCommand) -> CommandView:
    """Release a held vehicle: after a hold, a takeover, a minimal-risk stop or a restart."""
    return await command.transact(
        CommandView, lambda uow: command_view(vehicle_commands.resume(uow, vehicle_id, command.by))
    )


@router.post("/{vehicle_id}/stop-now", operation_id="stop_vehicle_now", status_code=202, responses=COMMAND)
async def stop_vehicle_now(vehicle_id: VehicleId, command: StopCommand) -> CommandView:
    """Stop as hard as is safe, and stay held."""
    return await command.transact(
        CommandView, lambda uow: command_view(vehicle_commands.stop_now(uow, vehicle_id, command.by))
    )


@router.post("/{vehicle_id}/announce", operation_id="announce_in_vehicle", status_code=202, responses=COMMAND)
async def announce_in_vehicle(
    vehicle_id: VehicleId, request: Announcement, command: DispatchCommand
) -> CommandView:
    """Say a text aloud in the vehicle and show it on its screen."""

    def work(uow: UnitOfWork) -> CommandView:
        return command_view(vehicle_commands.announce(uow, vehicle_id, command.by, request.text))

    return await command.transact(CommandView, work)


@router.post("/{vehicle_id}/recall", operation_id="recall_vehicle", responses=MOVE)
async def recall_vehicle(vehicle_id: VehicleId, command: MoveCommand) -> VehicleRecord:
    """Take it out of service: it first takes its riders to their stops, then rests."""
    return await command.transact(
        VehicleRecord, lambda uow: vehicle_record(vehicle_commands.recall(uow, vehicle_id, command.by))
    )


@router.post("/{vehicle_id}/release", operation_id="release_vehicle", responses=MOVE)
async def release_vehicle(vehicle_id: VehicleId, command: MoveCommand) -> VehicleRecord:
    """Put a recalled vehicle back into service."""
    return await command.transact(
        VehicleRecord, lambda uow: vehicle_record(vehicles.return_to_service(uow, vehicle_id, command.by))
    )


@router.post(
    "/{vehicle_id}/send",
    operation_id="send_vehicle",
    status_code=202,
    responses=problems(
        VehicleUnknown,
        StopUnknown,
        StopUnreachable,
        VehicleNotPlaced,
        VehicleOutOfService,
        NoRestingPlaceFree,
        *DRIVER_REFUSALS,
        *SECOND_FACTOR_REFUSALS,
    ),
)
async def send_vehicle(
    vehicle_id: VehicleId,
    stop_id: Annotated[StopId, Query(examples=["library"])],
    services: InjectedServices,
    command: MoveCommand,
    dry_run: Annotated[bool, Query(description="Only answer what it would do. Nothing changes.")] = False,
) -> VehicleDetail:
    """Let it visit a stop without a ride, at the first chance that keeps every promise (see `visits`)."""

    def work(uow: UnitOfWork) -> VehicleDetail:
        sent = vehicle_commands.send(uow, vehicle_id, stop_id, command.by)
        return vehicle_detail(sent.vehicle, uow.rules)

    if dry_run:
        return await roll_back(services.transactions, work)
    return await command.transact(VehicleDetail, work)


@router.post(
    "/{vehicle_id}/evacuations",
    operation_id="evacuate_vehicle",
    responses=problems(VehicleUnknown, NobodyAboard, *OPERATOR_REFUSALS),
)
async def evacuate_vehicle(vehicle_id: VehicleId, command: EvacuationCommand) -> list[RideRecord]:
    """It cannot go on: its riders are sent to the nearest stop, where another shuttle comes.

    The rides as they are planned now.
    """

    def work(uow: UnitOfWork) -> list[RideRecord]:
        moved = lost_vehicles.evacuate(uow, vehicle_id, command.by)
        return [
            ride_record(ride, secrets_of(uow, ride).boarding_code, outlook_of(uow, ride)) for ride in moved
        ]

    return await command.transact(list[RideRecord], work)


@router.put(
    "/{vehicle_id}/place",
    operation_id="place_vehicle",
    responses=problems(
        VehicleUnknown, VehicleNotPlaced, SectionsTaken, *OPERATOR_REFUSALS, *SECOND_FACTOR_REFUSALS
    ),
)
async def place_vehicle(vehicle_id: VehicleId, request: Place, command: PlaceCommand) -> VehicleRecord:
    """Set the position of a held vehicle by hand."""

    def work(uow: UnitOfWork) -> VehicleRecord:
        return vehicle_record(vehicles.place(uow, vehicle_id, request.lane_id, request.s_m, command.by))

    return await command.transact(VehicleRecord, work)


@router.post(
    "/{vehicle_id}/position",
    operation_id="set_vehicle_position",
    status_code=202,
    responses=problems(
        VehicleUnknown, VehicleNotConnected, VehicleMoves, *OPERATOR_REFUSALS, *SECOND_FACTOR_REFUSALS
    ),
)
async def set_vehicle_position(
    vehicle_id: VehicleId, request: NamedPosition, command: PlaceCommand
) -> CommandView:
    """Tell a standing vehicle where it is. It compares its scans with the map there and answers within 20 s.

    `last_command` of the vehicle says what came of it. Near is enough: within 10 m, and 20 degrees.
    """
    pose = Pose2(request.x_m, request.y_m, math.remainder(request.yaw_rad, math.tau))
    return await command.transact(
        CommandView,
        lambda uow: command_view(vehicle_commands.set_position(uow, vehicle_id, pose, command.by)),
    )


@router.delete(
    "/{vehicle_id}",
    operation_id="retire_vehicle",
    responses=problems(VehicleUnknown, *OPERATOR_REFUSALS),
)
async def retire_vehicle(vehicle_id: VehicleId, command: AdminCommand) -> VehicleRecord:
    """Remove it from the road for good; others get its rides."""
    return await command.transact(
        VehicleRecord, lambda uow: vehicle_record(vehicles.retire(uow, vehicle_id, command.by))
    )


@router.delete(
    "/{vehicle_id}/key",
    operation_id="revoke_vehicle_key",
    responses=problems(KeyUnknown, *OPERATOR_REFUSALS),
)
async def revoke_vehicle_key(vehicle_id: VehicleId, command: AdminCommand) -> VehicleRecord:
    """Revoke the key and end the open session."""
    return await command.transact(
        VehicleRecord, lambda uow: vehicle_record(vehicles.revoke_key(uow, vehicle_id, command.by))
    )


@enrolments.post(
    "/codes",
    operation_id="make_enrolment_code",
    status_code=201,
    responses=problems(*OPERATOR_REFUSALS),
)
async def make_enrolment_code(request: NewVehicle, command: AdminCommand) -> CodeView:
    """A code with which the vehicle enrols its key, once. The vehicle is entered if it is new."""

    def work(uow: UnitOfWork) -> CodeView:
        code = identity.create_enrolment_code(
            uow,
            request.vehicle_id,
            request.name,
            command.by,
            seats=request.seats,
            wheelchair_places=request.wheelchair_places,
        )
        return CodeView(vehicle_id=request.vehicle_id, code=code)

    return await command.about(request.vehicle_id).transact(CodeView, work)


@enrolments.post(
    "",
    operation_id="enrol_vehicle",
    status_code=201,
    responses=problems(EnrolmentCodeUnknown, EnrolmentCodeUsed, KeyInvalid, TooManyTries),
)
async def enrol_vehicle(
    request: Enrolment, http: Request, services: InjectedServices, client: Client
) -> VehicleRecord:
    """Called by the vehicle: its key is enrolled."""
    services.limits.lookups.take(client, now_ns(services))
    caller = Caller("vehicle", request.vehicle_id, address_of(http))

    def work(uow: UnitOfWork) -> VehicleRecord:
        enrolled = vehicles.enrol(uow, request.code, request.vehicle_id, request.public_key)
        audit.append(uow, caller, AuditAction("enrol_vehicle", request.vehicle_id))
        return vehicle_record(enrolled)

    return await services.transactions.run(work)
