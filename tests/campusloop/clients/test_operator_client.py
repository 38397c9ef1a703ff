"""What the demos' operator reads is what the API answers."""

import asyncio

import httpx
import pytest

from campusloop.clients import operator_client
from campusloop.clients.demo_cameras import CAMERA_TOKEN
from campusloop.clients.operator_client import OperatorClient, ReportedRide, ReportedVehicle
from server.api.rides.schemas import RideRecord
from server.api.tokens.schemas import TokenRequest
from server.api.vehicles.schemas import VehicleDetail


def test_the_client_reads_no_field_that_the_api_does_not_have() -> None:
    assert set(ReportedRide.__annotations__) <= set(RideRecord.model_fields)
    assert set(ReportedVehicle.__annotations__) <= set(VehicleDetail.model_fields)


def test_a_token_is_asked_for_as_the_api_wants_it() -> None:
    asked: list[TokenRequest] = []

    def answer(request: httpx.Request) -> httpx.Response:
        assert request.url.path == "/api/v1/developer-tokens"
        asked.append(TokenRequest.model_validate_json(request.content))
        return httpx.Response(201, json={"secret": "s3cret"})

    async def make() -> str:
        transport = httpx.MockTransport(answer)
        async with httpx.AsyncClient(transport=transport, base_url="http://server") as client:
            return await OperatorClient(client).make_token(CAMERA_TOKEN, "infrastructure")

    assert asyncio.run(make()) == "s3cret"
    assert [(token.name, token.scopes) for token in asked] == [(CAMERA_TOKEN, {"infrastructure"})]


def test_a_vehicle_that_is_stopped_between_is_resumed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """It was resumed once: a stop before the operator's next look left it standing for ever."""
    monkeypatch.setattr(operator_client, "POLL_EVERY_S", 0.0)
    resumed = 0

    def answer(request: httpx.Request) -> httpx.Response:
        nonlocal resumed
        resumed += request.url.path.endswith("/resume")
        return httpx.Response(200, json={"connected": True, "placed": True, "held": resumed < 2})

    async def release() -> None:
        transport = httpx.MockTransport(answer)
        async with httpx.AsyncClient(transport=transport, base_url="http://server") as client:
            await OperatorClient(client).release("shuttle-1")

    asyncio.run(release())
    assert resumed == 2
