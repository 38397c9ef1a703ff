"""What one vehicle sees now, on request and for a minute."""

from datetime import timedelta

import msgspec
from fastapi import APIRouter, Response

from server.api.commands import RecordCommand
from server.api.formats import VehicleId
from server.api.problems import problems
from server.api.replays.routes import answer_of
from server.api.security.access import DRIVER_REFUSALS, READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.api.vehicles.schemas import CommandView, command_view
from server.domain.errors import VehicleNotConnected, VehicleUnknown
from server.domain.instants import ms_of
from server.live.onboard_scenes import ShownScene
from server.usecases.fleet import vehicle_commands
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

router = APIRouter(prefix="/vehicles/{vehicle_id}/scene", tags=["vehicles"])

# A vehicle shows its scene for so long after it has executed the request.
SHOWN = timedelta(seconds=60)


@router.post(
    "",
    operation_id="ask_for_scene",
    status_code=202,
    responses=problems(VehicleUnknown, VehicleNotConnected, *DRIVER_REFUSALS),
)
async def ask_for_scene(vehicle_id: VehicleId, command: RecordCommand) -> CommandView:
    """The vehicle sends what it sees and plans for 60 s; ask again for more.

    Obstacle cells, road users, signs, points of its lidars, limits, its s-t graph and tick times.

    A vehicle that is out of reach is not asked. One that hears of it more than 10 s later refuses.
    """
    return await command.transact(
        CommandView, lambda uow: command_view(vehicle_commands.show_scene(uow, vehicle_id, command.by))
    )


@router.get(
    "",
    operation_id="get_scene",
    response_class=Response,
    responses=problems(VehicleUnknown, *READER_REFUSALS)
    | answer_of("ShownScene", "The newest scene that came, however old; null before the first."),
)
async def get_scene(vehicle_id: VehicleId, services: InjectedServices, _: Reader) -> Response:
    """What the vehicle shows. While it does, a new scene comes 2.5 times a second."""
    found = services.onboard.newest(vehicle_id)

    def work(uow: UnitOfWork) -> ShownScene:
        vehicle = enrolled_vehicle(uow, vehicle_id)
        asked = uow.vehicles.newest_command(vehicle_id, "show_scene")
        if asked is not None and uow.now - asked.made_at > SHOWN:
            asked = None
        return ShownScene(
            vehicle_id=vehicle_id,
            connected=vehicle.connected,
            now_ms=ms_of(uow.now),
            request="" if asked is None else asked.state,
            detail="" if asked is None else asked.detail,
            received_ms=0 if found is None else ms_of(found.received_at),
            scene=None if found is None else found.scene,
        )

    shown = await services.transactions.read(work)
    return Response(msgspec.json.encode(shown), media_type="application/json")
