"""A client with the console's requests, for demos and tests."""

import asyncio
from collections.abc import Mapping
from typing import Any, TypedDict

import httpx

from vehicle_agent.config import Body

POLL_EVERY_S = 0.5
# A stop in between, e.g. by a late first percept, holds the vehicle again.
RESUME_AGAIN_POLLS = 10


class OperatorError(Exception):
    """The server refused a request; the message is the problem's title and detail."""


class ReportedVehicle(TypedDict):
    """The fields of the API's vehicle that this client reads."""

    connected: bool
    placed: bool
    held: bool
    map_version: str


class ReportedRide(TypedDict):
    """The fields of the API's ride that this client's users read. Moments are ISO 8601 texts in UTC."""

    ride_id: str
    ride_code: str
    state: str
    from_stop: str
    to_stop: str
    party: int
    earliest: str
    requested_at: str
    promise: dict[str, str] | None
    vehicle_id: str | None
    boarded_at: str | None
    ended_at: str | None
    reason: str
    reason_detail: str


class OperatorClient:
    """Call `sign_in` first. The methods raise OperatorError when the server refuses a request."""

    def __init__(self, client: httpx.AsyncClient) -> None:
        """client: has the server's base URL; its cookie jar keeps the session."""
        self._client = client
        self._csrf = ""

    async def sign_in(self, name: str, password: str) -> None:
        session = await self._post("/api/v1/session", {"name": name, "password": password})
        self._csrf = session.json()["csrf_token"]
        # Behind a proxy with TLS, the server marks its cookie for HTTPS only. That is for browsers: this
        # program was given the address that it uses.
        for cookie in self._client.cookies.jar:
            cookie.secure = False

    @property
    def headers(self) -> dict[str, str]:
        """What a request that changes something needs besides the session's cookie."""
        return {"X-CSRF-Token": self._csrf} if self._csrf else {}

    async def enrol(self, vehicle_id: str, body: Body, public_key: str) -> None:
        """Create a code for the vehicle and, as the vehicle, enrol its key with the code."""
        name = vehicle_id.replace("-", " ").capitalize()
        created = await self._post(
            "/api/v1/enrolments/codes",
            {
                "vehicle_id": vehicle_id,
                "name": name,
                "seats": body.seats,
                "wheelchair_places": body.wheelchair_places,
            },
        )
        code = created.json()["code"]
        enrolment = {"code": code, "vehicle_id": vehicle_id, "public_key": public_key}
        await self._post("/api/v1/enrolments", enrolment)

    async def vehicle(self, vehicle_id: str) -> ReportedVehicle:
        answer = _checked(await self._client.get(f"/api/v1/vehicles/{vehicle_id}"))
        reported: ReportedVehicle = answer.json()
        return reported

    async def vehicles(self) -> list[dict[str, Any]]:
        return await self._list("/api/v1/vehicles")

    async def newest_rides(self, limit: int) -> list[ReportedRide]:
        """The rides requested last, newest first."""
        answer = await self._client.get("/api/v1/rides", params={"limit": limit})
        rides: list[ReportedRide] = _checked(answer).json()
        return rides

    async def ride(self, ride_id: str) -> ReportedRide:
        ride: ReportedRide = _checked(await self._client.get(f"/api/v1/rides/id/{ride_id}")).json()
        return ride

    async def release(self, vehicle_id: str) -> None:
        """Wait until the vehicle is connected and placed, and resume it until it is not held."""
        polls = 0
        while True:
            vehicle = await self.vehicle(vehicle_id)
            if vehicle["connected"] and vehicle["placed"]:
                if not vehicle["held"]:
                    return
                if polls % RESUME_AGAIN_POLLS == 0:
                    await self.command(vehicle_id, "resume")
                polls += 1
            await asyncio.sleep(POLL_EVERY_S)

    async def command(self, vehicle_id: str, verb: str) -> None:
        """verb: hold, resume, stop-now, recall or release."""
        await self._post(f"/api/v1/vehicles/{vehicle_id}/{verb}", None)

    async def make_token(self, name: str, scope: str, valid_days: float = 30.0) -> str:
        """A new token's secret, for a script or a camera."""
        request = {"name": name, "scopes": [scope], "valid_days": valid_days}
        made = await self._post("/api/v1/developer-tokens", request)
        secret: str = made.json()["secret"]
        return secret

    async def incidents(self) -> list[dict[str, Any]]:
        return await self._list("/api/v1/incidents")

    async def _list(self, path: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = _checked(await self._client.get(path)).json()
        return found

    async def _post(self, path: str, body: Mapping[str, object] | None) -> httpx.Response:
        return _checked(await self._client.post(path, json=body, headers=self.headers))


def _checked(answer: httpx.Response) -> httpx.Response:
    if answer.is_error:
        problem: Mapping[str, object] = answer.json()
        raise OperatorError(f"{answer.request.url.path}: {problem.get('title')}: {problem.get('detail')}")
    return answer
