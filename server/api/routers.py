"""Every router, and the application made of them without the services that `app.py` adds."""

from typing import Any

from fastapi import APIRouter, FastAPI

from server.api import (
    campus,
    closures,
    developer_socket,
    health,
    incidents,
    infrastructure_socket,
    interventions,
    live_socket,
    problems,
    rides,
    runs,
    segments,
    series,
    service,
    sessions,
    shifts,
    tokens,
    travel_times,
    vehicle_socket,
    vehicles,
)
from server.api.openapi import openapi_of

PREFIX = "/api/v1"
VERSION = "1.0.0"
# Requests are small; run segments set their own limit.
REQUEST_BYTES_MAX = 64 * 1024


def bare_app(**options: Any) -> FastAPI:
    """All endpoints, sockets and problem answers; options go to FastAPI."""
    app = FastAPI(
        title="Campusloop",
        version=VERSION,
        openapi_url=f"{PREFIX}/openapi.json",
        docs_url=None,  # the interactive pages load scripts from elsewhere, which our policy forbids
        redoc_url=None,
        **options,
    )
    api = APIRouter(prefix=PREFIX, max_body_size=REQUEST_BYTES_MAX)
    for router in (
        campus.router,
        rides.router,
        series.router,
        service.router,
        closures.router,
        travel_times.router,
        sessions.router,
        vehicles.router,
        shifts.router,
        vehicles.enrolments,
        interventions.router,
        incidents.router,
        segments.router,
        runs.router,
        tokens.router,
        health.router,
    ):
        api.include_router(router)
    app.include_router(api)
    for router in (
        vehicle_socket.router,
        live_socket.router,
        developer_socket.router,
        infrastructure_socket.router,
    ):
        app.include_router(router)
    problems.install(app)
    document: dict[str, Any] = {}

    def openapi() -> dict[str, Any]:
        if not document:
            document.update(openapi_of(app, VERSION))
        return document

    app.openapi = openapi  # type: ignore[method-assign]
    return app
