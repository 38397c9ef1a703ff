"""The services of all endpoints: made once by `app.py`, and kept in the application's state."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection

from contract.tracing import RideSpans
from server.api.metrics.measurements import Measurements
from server.api.pages import Page
from server.api.rides.booking_batcher import BookingBatcher
from server.api.security.access_watch import AccessWatch
from server.api.security.rate_limit import RateLimit
from server.fleet.hub import Hub
from server.fleet.presence import PresenceRelay
from server.live.camera_pictures import CameraPictures
from server.live.feed import SceneFeed
from server.live.onboard_scenes import OnboardScenes
from server.settings import Settings
from server.store.segments.segment_store import SegmentStore
from server.supervision.supervisor import Supervisor
from server.usecases.planning.forks import Forks
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock, Ids
from server.usecases.ports.maps import MapWorkshop
from server.usecases.ports.offload import Offload
from server.usecases.ports.push import PushSender
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.ports.webhooks import WebhookSender


@dataclass(frozen=True, slots=True)
class Limits:
    """Rate limits.

    logins          sign-ins of a client network; known_logins of a browser that has signed in before
    account_logins  sign-ins as one operator, from all browsers that have not
    lookups         codes tried by a client network
    bookings        of a client network or developer token
    offers          looks of a client network for a free shuttle
    commands        of an operator, a developer token or the holder of a ride's link
    second_factors  codes of authenticators tried by an operator
    password_checks  how many passwords are compared at a time: each takes 64 MiB and a core
    """

    logins: RateLimit
    known_logins: RateLimit
    account_logins: RateLimit
    lookups: RateLimit
    bookings: RateLimit
    offers: RateLimit
    commands: RateLimit
    second_factors: RateLimit
    password_checks: asyncio.Semaphore


@dataclass(frozen=True, slots=True)
class Services:
    """has_our_tables: the database's tables are those of this version; it may block.

    tiles           of localization maps
    scans           parcels of lidar scans, and the maps that are proposed of them
    videos          video segments of vehicles' cameras
    makes_maps      some process of this installation makes such maps
    webhook_sender  None: this server sends nothing to other networks
    push_sender     None: this server sends nothing to browsers
    spans           None: rides are not traced
    """

    campus_id: str
    settings: Settings
    clock: Clock
    ids: Ids
    transactions: Transactions
    bookings: BookingBatcher
    bus: Bus
    offload: Offload
    segments: SegmentStore
    tiles: SegmentStore
    scans: SegmentStore
    videos: SegmentStore
    hub: Hub
    presence: PresenceRelay
    feed: SceneFeed
    onboard: OnboardScenes
    cameras: CameraPictures
    supervisor: Supervisor
    access: AccessWatch
    measurements: Measurements
    limits: Limits
    has_our_tables: Callable[[], bool]
    makes_maps: bool
    maps: MapWorkshop
    forks: Forks
    webhook_sender: WebhookSender | None
    push_sender: PushSender | None
    spans: RideSpans | None
    pages: dict[str, Page]


async def services_of(connection: HTTPConnection) -> Services:
    services = connection.app.state.services
    assert isinstance(services, Services)
    return services


InjectedServices = Annotated[Services, Depends(services_of)]
