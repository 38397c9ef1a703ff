"""Liveness and readiness of the server."""

from typing import Literal

from fastapi import APIRouter, Response
from pydantic import BaseModel, ConfigDict

from server.api.services import InjectedServices
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(tags=["health"])


class Health(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": {"status": "ok"}})

    status: Literal["ok"]


class Readiness(BaseModel):
    """ready: the store answers and a campus map is active."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {"ready": True, "map_version": "3f0c9a71d2e84b55", "vehicles_connected": 3}
        }
    )

    ready: bool
    map_version: str
    vehicles_connected: int


@router.get("/health", operation_id="get_health")
async def get_health() -> Health:
    """The process runs."""
    return Health(status="ok")


@router.get(
    "/ready",
    operation_id="get_readiness",
    responses={503: {"model": Readiness, "description": "No campus map is active yet."}},
)
async def get_readiness(response: Response, services: InjectedServices) -> Readiness:
    """It can take bookings."""

    def work(uow: UnitOfWork) -> str:
        return uow.maps.active_version() or ""

    map_version = await services.transactions.read(work)
    if not map_version:
        response.status_code = 503
    return Readiness(
        ready=bool(map_version), map_version=map_version, vehicles_connected=len(services.hub.connected())
    )
