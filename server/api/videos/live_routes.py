"""What a camera of a vehicle sees now, on request and for a minute."""

from datetime import timedelta
from typing import Annotated

import msgspec
from fastapi import APIRouter, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from contract.video import CAMERA
from server.api.commands import WatchVideoCommand
from server.api.formats import VehicleId
from server.api.problems import problems
from server.api.replays.routes import answer_of
from server.api.security.access import LOOKING_REFUSALS, OPERATOR_REFUSALS
from server.api.services import InjectedServices
from server.api.vehicles.schemas import CommandView, command_view
from server.api.videos.routes import Watcher
from server.domain.errors import VehicleNotConnected, VehicleUnknown
from server.domain.instants import ms_of
from server.live.camera_pictures import ShownCamera
from server.usecases.fleet import vehicle_commands
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

router = APIRouter(prefix="/vehicles/{vehicle_id}/camera", tags=["videos"])

# A vehicle sends pictures for so long after it has heard the request.
SHOWN = timedelta(seconds=60)
_NAME = f"^({CAMERA})?$"


class CameraRequest(BaseModel):
    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"camera": "front"}})

    camera: str = Field("", pattern=_NAME, description="Its name; without one the vehicle's first camera.")


@router.post(
    "",
    operation_id="ask_for_camera",
    status_code=202,
    responses=problems(VehicleUnknown, VehicleNotConnected, *OPERATOR_REFUSALS),
)
async def ask_for_camera(
    vehicle_id: VehicleId, request: CameraRequest, command: WatchVideoCommand
) -> CommandView:
    """The vehicle sends pictures of a camera for 60 s, twice a second; ask again for more.

    The request is in the audit log. A vehicle that is out of reach is not asked. The vehicle's own setting
    decides how much a picture shows: it can be so coarse that no face and no plate can be read,
    or not come at all.
    """
    told = command.about(vehicle_id, request.camera)
    return await told.transact(
        CommandView,
        lambda uow: command_view(vehicle_commands.show_camera(uow, vehicle_id, request.camera, command.by)),
    )


@router.get(
    "",
    operation_id="get_camera_picture",
    response_class=Response,
    responses=problems(VehicleUnknown, *LOOKING_REFUSALS)
    | answer_of("ShownCamera", "The newest picture that came, or why none comes; null before the first."),
)
async def get_camera_picture(
    vehicle_id: VehicleId,
    services: InjectedServices,
    _: Watcher,
    camera: Annotated[str, Query(pattern=_NAME, description="Without one: whichever came last.")] = "",
) -> Response:
    """What the camera shows. There is a picture only within a minute of a request."""

    def work(uow: UnitOfWork) -> ShownCamera:
        vehicle = enrolled_vehicle(uow, vehicle_id)
        asked = uow.vehicles.newest_command(vehicle_id, "show_camera")
        if asked is None or uow.now - asked.made_at > SHOWN:
            return ShownCamera(vehicle_id, vehicle.connected, ms_of(uow.now))
        found = services.cameras.newest(vehicle_id, camera)
        return ShownCamera(
            vehicle_id=vehicle_id,
            connected=vehicle.connected,
            now_ms=ms_of(uow.now),
            request=asked.state,
            detail=asked.detail,
            received_ms=0 if found is None else ms_of(found.received_at),
            picture=None if found is None else found.picture,
        )

    shown = await services.transactions.read(work)
    headers = {"Cache-Control": "no-store"}
    return Response(msgspec.json.encode(shown), media_type="application/json", headers=headers)
