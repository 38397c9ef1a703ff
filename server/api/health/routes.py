"""Liveness and readiness of the server."""

import shutil

import structlog
from fastapi import APIRouter, Response

from server.api.health.schemas import Health, Readiness, task_readiness
from server.api.services import InjectedServices, Services
from server.domain.errors import DomainError
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(tags=["health"])

log = structlog.get_logger("api.health")


@router.get("/health", operation_id="get_health")
async def get_health() -> Health:
    """The process runs."""
    return Health(status="ok")


@router.get(
    "/ready",
    operation_id="get_readiness",
    responses={503: {"model": Readiness, "description": "Something that the server needs is missing."}},
)
async def get_readiness(response: Response, services: InjectedServices) -> Readiness:
    """It can take bookings, and everything that follows from them is done."""
    answer = await _readiness(services)
    if not answer.ready:
        response.status_code = 503
    return answer


async def _readiness(services: Services) -> Readiness:
    def work(uow: UnitOfWork) -> str:
        return uow.maps.active_version() or ""

    settings, now = services.settings, services.clock.now()
    map_version, answers = "", True
    try:
        map_version = await services.transactions.read(work)
        is_ours = await services.offload.run(services.has_our_tables)
    except DomainError as error:
        log.warning("database.unavailable", code=error.code, detail=error.detail)
        answers, is_ours = False, True
    free = await services.offload.run(lambda: shutil.disk_usage(settings.var_dir).free)
    tasks = [task_readiness(health, now) for health in services.supervisor.health()]
    has_room = free >= settings.disk_free_bytes_min
    return Readiness(
        ready=bool(map_version)
        and not services.hub.is_leaving
        and answers
        and is_ours
        and has_room
        and all(task.state == "good" for task in tasks),
        map_version=map_version,
        vehicles_connected=len(services.hub.connected()),
        leaving=services.hub.is_leaving,
        database="unavailable" if not answers else "good" if is_ours else "foreign",
        disk_free_bytes=free,
        disk_has_room=has_room,
        tasks=tasks,
    )
