"""Vehicles: operators see and command them; a vehicle enrols itself."""

from typing import Annotated

from fastapi import APIRouter, Query

from server.api.formats import StopId, VehicleId
from server.api.interventions.schemas import HoldSeconds
from server.api.problems import CsrfMissing, problems
from server.api.rides.schemas import RideRecord, ride_record
from server.api.security.access import (
    ChangingOperator,
    Client,
    ReadingOperator,
    now_ns,
)
from server.api.security.rate_limit import TooManyTries
from server.api.services import InjectedServices
from server.api.vehicles.schemas import (
    Announcement,
    CodeView,
    CommandView,
    Enrolment,
    NewVehicle,
    Place,
    VehicleDetail,
    VehicleFacts,
    command_view,
    vehicle_detail,
    vehicle_facts,
)
from server.domain.errors import (
    EnrolmentCodeUnknown,
    EnrolmentCodeUsed,
    KeyInvalid,
    KeyUnknown,
    NobodyAboard,
    NoRestingPlaceFree,
    SectionsTaken,
    SessionExpired,
    StopUnknown,
    StopUnreachable,
    VehicleNotPlaced,
    VehicleOutOfService,
    VehicleUnknown,
)
from server.usecases.fleet import vehicle_commands, vehicles
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from server.usecases.rides import lost_vehicles

router = APIRouter(prefix="/vehicles", tags=["vehicles"])
enrolments = APIRouter(prefix="/enrolments", tags=["vehicles"])

COMMAND = problems(VehicleUnknown, SessionExpired, CsrfMissing)


@router.get("", operation_id="list_vehicles", responses=problems(SessionExpired))
async def list_vehicles(services: InjectedServices, _: ReadingOperator) -> list[VehicleDetail]:
    """By id, retired ones left out."""
    return await services.transactions.read(
        lambda uow: [vehicle_detail(view, uow.rules) for view in uow.views.vehicles()]
    )


@router.get("/{vehicle_id}", operation_id="get_vehicle", responses=problems(VehicleUnknown, SessionExpired))
async def get_vehicle(vehicle_id: VehicleId, services: InjectedServices, _: ReadingOperator) -> VehicleDetail:
    def work(uow: UnitOfWork) -> VehicleDetail:
        view = uow.views.vehicle(vehicle_id)
        if view is None:
            raise VehicleUnknown(f"no vehicle is called {vehicle_id}; see GET /vehicles")
        return vehicle_detail(view, uow.rules)

    return await services.transactions.read(work)


@router.post("/{vehicle_id}/hold", operation_id="hold_vehicle", status_code=202, responses=COMMAND)
async def hold_vehicle(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator, for_s: HoldSeconds = None
) -> CommandView:
    """Come to a comfortable stand, until resumed or for a time. See the preview."""
    return command_view(await vehicle_commands.pause(services.transactions, vehicle_id, operator.name, for_s))


@router.post("/{vehicle_id}/resume", operation_id="resume_vehicle", status_code=202, responses=COMMAND)
async def resume_vehicle(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> CommandView:
    """Release a held vehicle: after a hold, a takeover, a minimal-risk stop or a restart."""
    return command_view(await vehicle_commands.resume(services.transactions, vehicle_id, operator.name))


@router.post("/{vehicle_id}/stop-now", operation_id="stop_vehicle_now", status_code=202, responses=COMMAND)
async def stop_vehicle_now(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> CommandView:
    """Stop as hard as is safe, and stay held."""
    return command_view(await vehicle_commands.stop_now(services.transactions, vehicle_id, operator.name))


@router.post("/{vehicle_id}/announce", operation_id="announce_in_vehicle", status_code=202, responses=COMMAND)
async def announce_in_vehicle(
    vehicle_id: VehicleId, request: Announcement, services: InjectedServices, operator: ChangingOperator
) -> CommandView:
    """Say a text aloud in the vehicle and show it on its screen."""
    return command_view(
        await vehicle_commands.announce(services.transactions, vehicle_id, operator.name, request.text)
    )


@router.post("/{vehicle_id}/recall", operation_id="recall_vehicle", responses=COMMAND)
async def recall_vehicle(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> VehicleFacts:
    """Take it out of service: it first takes its riders to their stops, then rests."""
    return vehicle_facts(await vehicle_commands.recall(services.transactions, vehicle_id, operator.name))


@router.post("/{vehicle_id}/release", operation_id="release_vehicle", responses=COMMAND)
async def release_vehicle(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> VehicleFacts:
    """Put a recalled vehicle back into service."""
    return vehicle_facts(
        await services.transactions.run(
            lambda uow: vehicles.return_to_service(uow, vehicle_id, operator.name)
        )
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
        SessionExpired,
        CsrfMissing,
    ),
)
async def send_vehicle(
    vehicle_id: VehicleId,
    stop_id: Annotated[StopId, Query(examples=["library"])],
    services: InjectedServices,
    operator: ChangingOperator,
) -> VehicleDetail:
    """Let it visit a stop without a ride, at the first chance that keeps every promise."""
    await vehicle_commands.send(services.transactions, vehicle_id, stop_id, operator.name)
    return await get_vehicle(vehicle_id, services, operator)


@router.post(
    "/{vehicle_id}/evacuations",
    operation_id="evacuate_vehicle",
    responses=problems(VehicleUnknown, NobodyAboard, SessionExpired, CsrfMissing),
)
async def evacuate_vehicle(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> list[RideRecord]:
    """It cannot go on: its riders are sent to the nearest stop, where another shuttle comes.

    The rides as they are planned now.
    """
    moved = await services.transactions.run(
        lambda uow: lost_vehicles.evacuate(uow, vehicle_id, operator.name)
    )
    return [ride_record(ride) for ride in moved]


@router.put(
    "/{vehicle_id}/place",
    operation_id="place_vehicle",
    responses=problems(VehicleUnknown, VehicleNotPlaced, SectionsTaken, SessionExpired, CsrfMissing),
)
async def place_vehicle(
    vehicle_id: VehicleId, request: Place, services: InjectedServices, operator: ChangingOperator
) -> VehicleFacts:
    """Set the position of a held vehicle by hand."""
    return vehicle_facts(
        await services.transactions.run(
            lambda uow: vehicles.place(uow, vehicle_id, request.lane_id, request.s_m, operator.name)
        )
    )


@router.delete("/{vehicle_id}", operation_id="retire_vehicle", responses=COMMAND)
async def retire_vehicle(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> VehicleFacts:
    """Remove it from the road for good; others get its rides."""
    return vehicle_facts(
        await services.transactions.run(lambda uow: vehicles.retire(uow, vehicle_id, operator.name))
    )


@router.delete(
    "/{vehicle_id}/key",
    operation_id="revoke_vehicle_key",
    responses=problems(KeyUnknown, SessionExpired, CsrfMissing),
)
async def revoke_vehicle_key(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> VehicleFacts:
    """Revoke the key and end the open session."""
    return vehicle_facts(
        await services.transactions.run(lambda uow: vehicles.revoke_key(uow, vehicle_id, operator.name))
    )


@enrolments.post(
    "/codes",
    operation_id="make_enrolment_code",
    status_code=201,
    responses=problems(SessionExpired, CsrfMissing),
)
async def make_enrolment_code(
    request: NewVehicle, services: InjectedServices, operator: ChangingOperator
) -> CodeView:
    """A code with which the vehicle enrols its key, once. The vehicle is entered if it is new."""
    code = await services.transactions.run(
        lambda uow: identity.create_enrolment_code(
            uow,
            request.vehicle_id,
            request.name,
            operator.name,
            seats=request.seats,
            wheelchair_places=request.wheelchair_places,
        )
    )
    return CodeView(vehicle_id=request.vehicle_id, code=code)


@enrolments.post(
    "",
    operation_id="enrol_vehicle",
    status_code=201,
    responses=problems(EnrolmentCodeUnknown, EnrolmentCodeUsed, KeyInvalid, TooManyTries),
)
async def enrol_vehicle(request: Enrolment, services: InjectedServices, client: Client) -> VehicleFacts:
    """Called by the vehicle: its key is enrolled."""
    services.limits.lookups.take(client, now_ns(services))
    return vehicle_facts(
        await services.transactions.run(
            lambda uow: vehicles.enrol(uow, request.code, request.vehicle_id, request.public_key)
        )
    )
