"""Every answer has an id, and what the server logs for the request has the same."""

import asyncio
from typing import Any

import httpx
import pytest
import structlog

from server.adapters import SeededIds, SystemClock
from server.api.problems import install
from server.api.request_ids import RequestIds, current_request_id
from server.api.rides.booking_batcher import BookingBatcher
from server.api.routers import bare_app
from server.domain.rides.rides import BookRide
from tests.server.api.server_under_test import ServerUnderTest


@pytest.mark.parametrize("path", ["/campus", "/rides", "/nowhere"])
def test_an_answer_has_the_id_that_the_client_gave(server: ServerUnderTest, path: str) -> None:
    answer = server.get(path, headers={"X-Request-Id": "my-request_7"})
    assert answer.headers.get_list("x-request-id") == ["my-request_7"]


@pytest.mark.parametrize("given", ["", "a" * 65, "two words", 'a"b', "a\\nb", "é"])
def test_an_id_that_is_not_safe_to_log_is_replaced(server: ServerUnderTest, given: str) -> None:
    answer = server.get("/campus", headers=[(b"x-request-id", given.encode())])
    assert answer.headers["x-request-id"].startswith("request-")


def test_two_ids_are_none(server: ServerUnderTest) -> None:
    answer = server.get("/campus", headers=[("x-request-id", "one"), ("x-request-id", "two")])
    assert answer.headers["x-request-id"].startswith("request-")


@pytest.mark.parametrize("path", ["/rides", "/nowhere", "/stops?limit=never"])
def test_problem_details_name_the_request(server: ServerUnderTest, path: str) -> None:
    answer = server.get(path)
    if answer.is_error:
        assert answer.json()["request_id"] == answer.headers["x-request-id"] != ""


def test_a_page_has_an_id_as_well(server: ServerUnderTest) -> None:
    answer = server.run(server.client.get("/"))
    assert answer.headers["x-request-id"].startswith("request-")


def test_no_id_is_left_after_the_request(server: ServerUnderTest) -> None:
    server.get("/campus")
    assert current_request_id() == ""


def test_the_answer_of_a_crash_has_the_id_of_its_log_line() -> None:
    app = bare_app()
    logged: list[str] = []

    @app.get("/crash")
    async def crash() -> None:
        logged.append(current_request_id())
        raise ArithmeticError("a defect")

    app.add_middleware(RequestIds, ids=SeededIds(1))
    install(app)
    transport = httpx.ASGITransport(app, raise_app_exceptions=False)

    async def ask() -> httpx.Response:
        async with httpx.AsyncClient(transport=transport, base_url="http://campus.test") as client:
            return await client.get("/crash")

    answer = asyncio.run(ask())
    assert answer.status_code == 500
    assert [answer.headers["x-request-id"]] == [answer.json()["request_id"]] == logged == ["request-1"]


def test_a_websocket_has_an_id_in_its_handshake_and_in_the_log() -> None:
    logged: list[Any] = []

    async def socket(scope: Any, receive: Any, send: Any) -> None:
        logged.append(structlog.contextvars.get_contextvars())
        await send({"type": "websocket.accept"})

    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        return {"type": "websocket.connect"}

    asyncio.run(RequestIds(socket, SeededIds(1))({"type": "websocket", "headers": []}, receive, send))
    assert logged == [{"connection_id": "connection-1"}]
    assert sent == [{"type": "websocket.accept", "headers": [(b"x-connection-id", b"connection-1")]}]


def test_bookings_that_are_decided_together_are_logged_with_all_their_ids() -> None:
    logged: list[str] = []

    class Transactions:
        async def run(self, work: object) -> list[Any]:
            ids = current_request_id()
            logged.append(ids)
            return [RuntimeError() for _ in ids.split(",")]

        read = run

    async def book(batcher: BookingBatcher, request_id: str) -> None:
        ids = structlog.contextvars.bound_contextvars(request_id=request_id)
        with ids, pytest.raises(RuntimeError):
            await batcher.book(BookRide("a", "b", 1))

    async def scenario() -> None:
        batcher = BookingBatcher(Transactions(), SystemClock())  # type: ignore[arg-type]
        await asyncio.gather(*(book(batcher, name) for name in ("one", "two")))

    asyncio.run(scenario())
    assert logged == ["one,two"]
