"""The server as `campusloop serve` runs it, on a free port, and a vehicle that obeys by websocket."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
from websockets.asyncio.client import ClientConnection, connect

from campusloop.live.draining_server import DrainingServer, draining_server
from campusloop.live.server import listen, uvicorn_config
from contract.geometry import Pose2
from contract.roads.network import RoadNetwork
from contract.wire.codec import decode_from_server, encode
from contract.wire.messages import (
    Challenge,
    EventReport,
    ModeChanged,
    Order,
    OrderAccepted,
    ServerMessage,
    Status,
    VisitChanged,
    Welcome,
)
from server.live_ports import live_ports
from server.settings import Settings
from tests.campusloop.secret_search import Secrets
from tests.server.api.server_under_test import MAPS, PASSWORD, snow_lion
from tests.server.fleet.vehicle_key import VehicleKeyPair, a_hello

# Beside vehicles in real time, which come first to a core.
ANSWER_S = 30.0


class LiveServer:
    def __init__(self, origin: str, server: DrainingServer) -> None:
        self.origin = origin
        self._server = server
        self.http = httpx.AsyncClient(base_url=f"{origin}/api/v1", trust_env=False, timeout=ANSWER_S)
        self._csrf: dict[str, str] = {}

    def stop(self) -> None:
        """As SIGTERM does."""
        self._server.should_exit = True

    async def sign_in(self) -> None:
        answer = await self.http.post("/session", json={"name": "operator", "password": PASSWORD})
        answer.raise_for_status()
        self._csrf = {"X-CSRF-Token": answer.json()["csrf_token"]}

    async def change(self, method: str, path: str, body: object = None) -> httpx.Response:
        answer = await self.http.request(method, path, json=body, headers=self._csrf)
        assert answer.is_success, answer.text
        return answer

    async def developer_token(self, *scopes: str) -> tuple[str, str]:
        """(secret, token id)"""
        made = await self.change("POST", "/developer-tokens", {"name": "test", "scopes": list(scopes)})
        return made.json()["secret"], made.json()["token_id"]

    async def enrol(self, vehicle_id: str) -> None:
        new = {"vehicle_id": vehicle_id, "name": vehicle_id.title()}
        code = (await self.change("POST", "/enrolments/codes", new)).json()["code"]
        key = VehicleKeyPair(vehicle_id).public_base64
        await self.change("POST", "/enrolments", {"code": code, "vehicle_id": vehicle_id, "public_key": key})


@asynccontextmanager
async def live_server(
    var_dir: Path, secrets: Secrets | None = None, **settings: object
) -> AsyncIterator[LiveServer]:
    """secrets: collects those that are handed out to the client."""
    listening = listen("127.0.0.1", 0)
    port = listening.getsockname()[1]
    chosen = Settings(
        port=port,
        var_dir=var_dir,
        web_dist=var_dir / "dist",
        map_path=MAPS / "snow-lion" / "map.json",
        operator_password=PASSWORD,
        live_interval_s=0.05,
        **settings,  # type: ignore[arg-type]
    )
    live = await live_ports(chosen)
    server = draining_server(uvicorn_config(chosen, live))
    serving = asyncio.get_running_loop().create_task(server.serve(sockets=[listening]))
    client = LiveServer(chosen.origin(), server)
    if secrets is not None:
        secrets.listen(client.http)
    try:
        async with asyncio.timeout(30):
            while not server.started:  # noqa: ASYNC110 - uvicorn has no event for it
                await asyncio.sleep(0.01)
        await client.sign_in()
        yield client
    finally:
        await client.http.aclose()
        server.should_exit = True
        await serving


class ObedientVehicle:
    """Stands at a resting place; takes every order and reports the visit asked for as reached."""

    def __init__(self, connection: ClientConnection, vehicle_id: str) -> None:
        self.heard: list[ServerMessage] = []
        self._connection, self._vehicle_id = connection, vehicle_id
        self._epoch = 0
        self._sequence = 0

    async def run(self) -> None:
        async for data in self._connection:
            message = decode_from_server(data)
            self.heard.append(message)
            if isinstance(message, Challenge):
                hello = a_hello(message.nonce, self._vehicle_id, map_version=snow_lion().map_version)
                await self._connection.send(encode(hello))
            elif isinstance(message, Welcome):
                self._epoch = message.epoch
                await self._stand_ready()
            elif isinstance(message, Order):
                await self._obey(message)

    async def _stand_ready(self) -> None:
        rest = snow_lion().resting_places[0]
        pose = Pose2(*RoadNetwork(snow_lion()).pose(rest.lane_id, rest.s_m))
        await self._event(ModeChanged("autonomous", detail="resumed"))
        status = Status(
            self._epoch, 5, pose, 0.0, 0.0, 0.0, "autonomous", 0.9, False, rest.lane_id, rest.s_m, "", 0, ""
        )
        await self._connection.send(encode(status))

    async def _obey(self, order: Order) -> None:
        await self._connection.send(encode(OrderAccepted(self._epoch, order.order_id, order.revision)))
        for visit in order.visits:
            if visit.kind == "stop":
                await self._event(VisitChanged(visit.visit_id, visit.stop_id, "under_way"))
                return

    async def _event(self, body: ModeChanged | VisitChanged) -> None:
        report = EventReport(self._epoch, "boot-1", self._sequence, 1_000 + self._sequence, body)
        self._sequence += 1
        await self._connection.send(encode(report))


@asynccontextmanager
async def obedient_vehicle(
    server: LiveServer, vehicle_id: str = "shuttle-1"
) -> AsyncIterator[ObedientVehicle]:
    await server.enrol(vehicle_id)
    url = server.origin.replace("http", "ws", 1) + "/ws/vehicle"
    async with connect(url, proxy=None) as connection:
        vehicle = ObedientVehicle(connection, vehicle_id)
        running = asyncio.get_running_loop().create_task(vehicle.run())
        async with asyncio.timeout(10):
            while not (await _detail(server, vehicle_id))["placed"]:  # noqa: ASYNC110
                await asyncio.sleep(0.05)
        try:
            yield vehicle
        finally:
            running.cancel()


async def _detail(server: LiveServer, vehicle_id: str) -> dict[str, object]:
    detail: dict[str, object] = (await server.http.get(f"/vehicles/{vehicle_id}")).json()
    return detail
