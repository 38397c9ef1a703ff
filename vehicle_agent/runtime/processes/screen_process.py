"""The onboard screen as a process: pages and a websocket on the vehicle's own network, without the cloud.

The tick never waits for it: its views come by mail, and what passengers touch goes to the tick's inbox like
a button. A screen can do what the buttons and the keypad in the cabin can, and nothing else.
"""

import asyncio
import ipaddress
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path

import msgspec
import structlog
from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import CabinUpdate, Deliveries, Delivery, Mailbox, MapAnswer
from vehicle_agent.runtime.screen.screen_pages import HEADERS, ScreenFile
from vehicle_agent.runtime.screen.screen_requests import (
    REQUEST_BYTES_MAX,
    RequestLimit,
    cabin_input,
    decode_request,
)
from vehicle_agent.runtime.screen.screen_scene import ScreenHistory
from vehicle_agent.runtime.screen.screen_settings import ScreenError, ScreenSettings

log = structlog.get_logger()

CLIENTS_MAX = 8
# A screen is told at least so often, so that it knows that the connection lives.
SEND_EVERY_S = 1.0
SEND_WITHIN_S = 5.0
OPEN_WITHIN_S = 5.0
TOO_MANY = "too_many"


class ScreenProcess:
    """Serves one vehicle's screen. Its mailbox is bound from the start."""

    def __init__(
        self,
        mail: Path,
        vehicle_id: str,
        seats: int,
        settings: ScreenSettings,
        read_files: Callable[[], dict[str, ScreenFile]],
        clock: Clock,
    ) -> None:
        self._mailbox = Mailbox(mail / "screen")
        self._tick = mail / "tick"
        self._settings = settings
        self._networks = settings.allowed()
        self._page = f"/onboard/{vehicle_id}"
        self._read_files = read_files
        self._files = read_files()
        self._clock = clock
        self._history = ScreenHistory(vehicle_id, seats)
        self._limit = RequestLimit()
        self._clients: set[ServerConnection] = set()
        self._changed = asyncio.Condition()

    async def run(self, stop: asyncio.Event) -> None:
        """Until `stop` is set. Raises ScreenError if the address cannot be used."""
        loop = asyncio.get_running_loop()
        loop.add_reader(self._mailbox.fileno(), self._collect)
        host, port = self._settings.address()
        try:
            server = serve(
                self._serve_client,
                host,
                port,
                process_request=self._answer_request,
                compression=None,
                max_size=REQUEST_BYTES_MAX,
                max_queue=4,
                open_timeout=OPEN_WITHIN_S,
                server_header=None,
            )
            async with server:
                log.info("screen.serving", address=f"http://{self._settings.listen}{self._page}")
                await stop.wait()
        except OSError as error:
            raise ScreenError(f"cannot serve the screen on {self._settings.listen} ({error})") from error
        finally:
            loop.remove_reader(self._mailbox.fileno())
            self._mailbox.close()

    # ------------------------------------------------------------ the tick's side

    def _collect(self) -> None:
        now_ns = self._clock.now_ns()
        mails = self._mailbox.take()
        if any(isinstance(mail, MapAnswer) and mail.refusal is None for mail in mails):
            # The pages of screens that are open ask for the map again when they connect again.
            self._files = self._read_files()
            self._leaving = [
                asyncio.ensure_future(client.close(1012, "another map")) for client in self._clients
            ]
        updates = [mail for mail in mails if isinstance(mail, CabinUpdate)]
        for update in updates:
            self._history.take(update.view, now_ns)
        if updates:
            self._wake = asyncio.ensure_future(self._notify())

    async def _notify(self) -> None:
        async with self._changed:
            self._changed.notify_all()

    # ------------------------------------------------------------ the screens' side

    def _answer_request(self, connection: ServerConnection, request: Request) -> Response | None:
        """A file, a refusal, or None: the websocket opens."""
        if not self._is_allowed(connection):
            return _response(HTTPStatus.FORBIDDEN)
        # Another site's page can make a browser send requests here, under a name of its own for this address.
        host = request.headers.get("Host", "")
        if not _is_plain_address(host):
            return _response(HTTPStatus.MISDIRECTED_REQUEST)
        path = request.path.split("?")[0]
        if path == "/":
            return _response(HTTPStatus.FOUND, {"Location": self._page})
        if path != f"{self._page}/live":
            file = self._files.get(path)
            if file is None:
                return _response(HTTPStatus.NOT_FOUND)
            headers = {"Content-Type": file.media_type, "Cache-Control": file.cache_control}
            return _response(HTTPStatus.OK, headers, file.body)
        if request.headers.get("Origin", "") != f"http://{host}":
            return _response(HTTPStatus.FORBIDDEN)
        if len(self._clients) >= CLIENTS_MAX:
            return _response(HTTPStatus.SERVICE_UNAVAILABLE)
        return None

    def _is_allowed(self, connection: ServerConnection) -> bool:
        address = ipaddress.ip_address(connection.remote_address[0].split("%")[0])
        mapped = getattr(address, "ipv4_mapped", None)
        return any((mapped or address) in network for network in self._networks)

    async def _serve_client(self, connection: ServerConnection) -> None:
        self._clients.add(connection)
        sending = asyncio.create_task(self._send_scenes(connection))
        try:
            async for data in connection:
                if not self._take_request(data):
                    await connection.send(msgspec.json.encode({"refused": TOO_MANY}).decode())
        except ConnectionClosed as closed:
            log.info("screen.closed", reason=str(closed))
        finally:
            self._clients.discard(connection)
            sending.cancel()
            await asyncio.wait((sending,))

    async def _send_scenes(self, connection: ServerConnection) -> None:
        """The newest scene, whenever it changes: what a slow screen misses is not kept for it."""
        try:
            while True:
                scene = msgspec.json.encode(self._history.scene(self._clock.now_ns())).decode()
                async with asyncio.timeout(SEND_WITHIN_S):
                    await connection.send(scene)
                async with self._changed:
                    try:
                        async with asyncio.timeout(SEND_EVERY_S):
                            await self._changed.wait()
                    except TimeoutError:
                        continue
        except (TimeoutError, ConnectionClosed):
            await connection.close(1001, "this screen does not keep up")

    def _take_request(self, data: str | bytes) -> bool:
        """False if there were too many of late. What is no request is noted and has no effect."""
        request = decode_request(data)
        if request is None:
            log.warning("screen.not_understood", size=len(data))
            return True
        now_ns = self._clock.now_ns()
        if not self._limit.take(request, now_ns):
            return False
        delivery = Delivery(now_ns, "screen", cabin_input(request, now_ns))
        if not self._mailbox.post(self._tick, Deliveries((delivery,))):
            log.warning("screen.request_lost", kind=type(request).__name__)
        return True


def _is_plain_address(host: str) -> bool:
    """An IP address or localhost, with or without a port: no name that a stranger could point here."""
    name = host.rpartition(":")[0] if host.count(":") == 1 or "]:" in host else host
    if name == "localhost":
        return True
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def _response(status: HTTPStatus, headers: dict[str, str] | None = None, body: bytes = b"") -> Response:
    fields = Headers(HEADERS | (headers or {}))
    fields["Content-Length"] = str(len(body))
    fields["Connection"] = "close"
    return Response(status.value, status.phrase, fields, body)
