"""Every router, and the application made of them without the services that `app.py` adds."""

from functools import cache
from typing import Any

from fastapi import APIRouter, FastAPI
from starlette.routing import BaseRoute

from server.api import problems
from server.api.announcements import routes as announcements
from server.api.audit import routes as audit
from server.api.basic import routes as basic
from server.api.campus import boards, travel_times
from server.api.campus import routes as campus
from server.api.closures import routes as closures
from server.api.health import routes as health
from server.api.incidents import routes as incidents
from server.api.interventions import routes as interventions
from server.api.localization_maps import routes as localization_maps
from server.api.localization_maps import tiles as localization_tiles
from server.api.localization_maps import vehicle_files as localization_vehicle_files
from server.api.maps import drafts as map_drafts
from server.api.maps import routes as maps
from server.api.maps import uploads as map_uploads
from server.api.maps import vehicle_files
from server.api.metrics import routes as metrics
from server.api.openapi import openapi_of
from server.api.operators import routes as operators
from server.api.recordings import routes as recordings
from server.api.replays import forks
from server.api.replays import routes as replays
from server.api.rides import notices, records
from server.api.rides import routes as rides
from server.api.runs import routes as runs
from server.api.runs import segments
from server.api.scans import parcels as scan_parcels
from server.api.scans import proposals as map_proposals
from server.api.scans import routes as scans
from server.api.scenes import routes as scenes
from server.api.series import routes as series
from server.api.service import routes as service
from server.api.service import timetables
from server.api.sessions import routes as sessions
from server.api.sessions import second_factor
from server.api.shift_log import routes as shift_log
from server.api.shifts import routes as shifts
from server.api.sockets import (
    board,
    developer,
    infrastructure,
    live,
    vehicle,
)
from server.api.statistics import routes as statistics
from server.api.tokens import routes as tokens
from server.api.vehicles import routes as vehicles
from server.api.videos import live_routes as live_videos
from server.api.videos import routes as videos
from server.api.webhooks import routes as webhooks

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
        docs_url=None,  # the interactive pages load foreign scripts, which our policy forbids
        redoc_url=None,
        routes=list(_routes()),
        **options,
    )
    problems.install(app)
    document: dict[str, Any] = {}

    def openapi() -> dict[str, Any]:
        if not document:
            document.update(openapi_of(app, VERSION))
        return document

    app.openapi = openapi  # type: ignore[method-assign]
    return app


@cache
def _routes() -> tuple[BaseRoute, ...]:
    """Every endpoint and socket, made once a process: they know no application, and take longest to make."""
    api = APIRouter(prefix=PREFIX, max_body_size=REQUEST_BYTES_MAX)
    for router in (
        campus.router,
        boards.router,
        map_uploads.router,
        map_drafts.router,
        maps.router,
        vehicle_files.router,
        localization_maps.router,
        localization_tiles.router,
        localization_vehicle_files.router,
        rides.router,
        notices.router,
        records.router,
        series.router,
        service.router,
        timetables.router,
        announcements.router,
        closures.router,
        travel_times.router,
        sessions.router,
        second_factor.router,
        operators.router,
        audit.router,
        vehicles.router,
        scenes.router,
        shifts.router,
        vehicles.enrolments,
        interventions.router,
        incidents.router,
        shift_log.router,
        scans.router,
        scan_parcels.router,
        videos.router,
        live_videos.router,
        map_proposals.router,
        segments.router,
        runs.router,
        recordings.router,
        forks.router,
        replays.router,
        statistics.router,
        tokens.router,
        webhooks.router,
        health.router,
        metrics.router,
    ):
        api.include_router(router)
    root = APIRouter()
    root.include_router(api)
    root.include_router(basic.router)
    for router in (
        vehicle.router,
        board.router,
        live.router,
        developer.router,
        infrastructure.router,
    ):
        root.include_router(router)
    return tuple(root.routes)
