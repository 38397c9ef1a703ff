"""Two parts of a virtual campus: the server's transport and the riders' phones."""

from typing import Literal

import httpx
from fastapi import FastAPI


class VirtualServer(httpx.AsyncBaseTransport):
    """A transport to the present server; there may be none, or later another one."""

    def __init__(self) -> None:
        self.app: FastAPI | None = None

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        if self.app is None:
            raise httpx.ConnectError("the server is down", request=request)
        return await httpx.ASGITransport(app=self.app).handle_async_request(request)


class VirtualPhones:
    """The vehicles that phones show, and their taps, which are sent to the server."""

    def __init__(self) -> None:
        self.vehicles: dict[str, str] = {}
        self.taps: list[tuple[str, Literal["board", "alight"]]] = []

    def vehicle_of(self, ride_id: str) -> str:
        return self.vehicles.get(ride_id, "")

    def tap(self, ride_id: str, kind: Literal["board", "alight"]) -> None:
        self.taps.append((ride_id, kind))
