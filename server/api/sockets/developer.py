"""/ws/developer: JSON-RPC 2.0 for scripts, opened with `Authorization: Bearer TOKEN`.

The connection ends with its token: when it is revoked or expires.
"""

import asyncio
from contextlib import AsyncExitStack
from datetime import datetime

from fastapi import APIRouter, WebSocket

from contract.wire.codec import decode_from_vehicle
from contract.wire.messages import EventReport
from server.api.security.access import developer_actor
from server.api.security.bearer import bearer_of
from server.api.security.request_origin import address_of
from server.api.services import InjectedServices, Services
from server.api.sockets.developer_messages import (
    ConnectionRefused,
    EventHappened,
    RidesChanged,
    VehiclesChanged,
)
from server.api.sockets.developer_methods import DeveloperMethods, Subscriptions
from server.api.sockets.json_rpc import answer, notification
from server.api.sockets.outgoing import OutgoingFrames, close_number
from server.domain.errors import DomainError, ScopeMissing, StoreFailure, TokenInvalid
from server.domain.instants import ms_of
from server.domain.record.identity import DeveloperToken
from server.live.scene import Delta, Snapshot
from server.usecases.ports import topics
from server.usecases.ports.bus import Subscription
from server.usecases.record import identity

router = APIRouter()

NOT_ALLOWED = 4401
FRAMES_WAITING_MAX = 200


@router.websocket("/ws/developer")
async def developer_socket(websocket: WebSocket, services: InjectedServices) -> None:
    await websocket.accept()
    secret = bearer_of(websocket)
    async with AsyncExitStack() as stack:
        try:
            token = await _token(services, secret)
            await stack.enter_async_context(services.feed.watched())
        except (TokenInvalid, ScopeMissing, StoreFailure) as error:
            await websocket.send_text(_refusal(error))
            await websocket.close(close_number(error, NOT_ALLOWED), error.code)
            return
        await _DeveloperConnection(websocket, services, secret, token).serve()


class _DeveloperConnection:
    """Answers requests in order; sends subscribed notifications in between."""

    def __init__(self, websocket: WebSocket, services: Services, secret: str, token: DeveloperToken) -> None:
        self._websocket, self._services, self._secret = websocket, services, secret
        self._subscriptions = Subscriptions()
        self._methods = DeveloperMethods(
            services, developer_actor(token), self._subscriptions, address_of(websocket)
        ).table()
        self._outgoing = OutgoingFrames(websocket, FRAMES_WAITING_MAX)

    async def serve(self) -> None:
        events = await self._services.bus.subscribe(topics.vehicle_event(self._services.campus_id, "*"))
        loop = asyncio.get_running_loop()
        sender = loop.create_task(self._outgoing.run())
        others = [
            loop.create_task(self._answer_requests()),
            loop.create_task(self._tell_scene()),
            loop.create_task(self._tell_events(events)),
            loop.create_task(self._until_revoked()),
        ]
        try:
            await asyncio.wait((sender, *others), return_when=asyncio.FIRST_COMPLETED)
        finally:
            await events.close()
            for task in (sender, *others):
                task.cancel()
        for task in (sender, *others):
            if task.done() and not task.cancelled():
                task.result()

    async def _answer_requests(self) -> None:
        while True:
            message = await self._websocket.receive()
            if message["type"] == "websocket.disconnect":
                return
            data: bytes | str = message.get("text") or message.get("bytes") or b""
            try:
                token = await _token(self._services, self._secret)
            except (TokenInvalid, ScopeMissing, StoreFailure) as error:
                await self._refuse(error)
                return
            response = await answer(data, self._methods, frozenset(token.scopes))
            if response is not None:
                self._outgoing.send(response)

    async def _until_revoked(self) -> None:
        async def expiry() -> datetime:
            return (await _token(self._services, self._secret)).expires_at

        await self._refuse(await self._services.access.until_refused(expiry))

    async def _refuse(self, error: DomainError) -> None:
        self._outgoing.send(_refusal(error).encode())
        self._outgoing.close(close_number(error, NOT_ALLOWED), error.code)
        # The sender ends the connection once the refusal is out.
        await asyncio.Event().wait()

    async def _tell_scene(self) -> None:
        services = self._services
        while True:
            for topic, viewer in self._subscriptions.viewers.items():
                message = viewer.next_message(services.feed.board, ms_of(services.clock.now()))
                params = None if message is None else _changes(topic, message)
                if params is not None:
                    self._outgoing.send(notification(topic, params))
            await asyncio.sleep(services.settings.live_interval_s)

    async def _tell_events(self, events: Subscription) -> None:
        async for topic, payload in events:
            if "events" not in self._subscriptions.topics:
                continue
            report = decode_from_vehicle(payload)
            assert isinstance(report, EventReport)
            vehicle_id = topic.split("/")[3]
            event = EventHappened(vehicle_id, report.boot_id, report.sequence, report.body)
            self._outgoing.send(notification("events", event))


def _changes(topic: str, message: Snapshot | Delta) -> VehiclesChanged | RidesChanged | None:
    """What a message of the scene says about this topic; None for nothing."""
    if isinstance(message, Snapshot):
        scene = message.scene
        if topic == "vehicles":
            return VehiclesChanged(scene.at_ms, True, scene.vehicles)
        return RidesChanged(scene.at_ms, True, scene.rides)
    if topic == "vehicles" and (message.vehicles or message.vehicles_gone):
        return VehiclesChanged(message.at_ms, False, message.vehicles, message.vehicles_gone)
    if topic == "rides" and (message.rides or message.rides_gone):
        return RidesChanged(message.at_ms, False, message.rides, message.rides_gone)
    return None


async def _token(services: Services, secret: str) -> DeveloperToken:
    """Raises TokenInvalid, ScopeMissing."""
    return await services.transactions.read(lambda uow: identity.developer_of(uow, secret, "read"))


def _refusal(error: DomainError) -> str:
    return notification("refused", ConnectionRefused(error.code, error.detail)).decode()
