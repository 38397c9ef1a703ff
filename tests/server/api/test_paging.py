"""Lists in pages: complete, in order, without repeats, whatever changes in between."""

import base64
import json
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.api.paging import microseconds_of, moment_of
from server.domain.record.incidents import IncidentKind
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import incidents
from tests.server.api.server_under_test import ServerUnderTest

LISTS = [
    "/rides",
    "/series",
    "/incidents?closed=true",
    "/runs",
    "/vehicles",
    "/closures",
    "/developer-tokens",
]


def pages(server: ServerUnderTest, path: str, limit: int) -> list[list[dict[str, Any]]]:
    found: list[list[dict[str, Any]]] = []
    url: str | None = f"{path}{'&' if '?' in path else '?'}limit={limit}"
    while url is not None and len(found) < 50:
        answer = server.get(url)
        assert answer.status_code == 200, answer.text
        found.append(answer.json())
        following = answer.links.get("next", {}).get("url")
        url = None if following is None else following.removeprefix("/api/v1")
    return found


def book(server: ServerUnderTest, count: int) -> list[str]:
    wish = {"from_stop": "NN7", "to_stop": "C6"}
    return [server.post("/rides", wish).json()["ride_id"] for _ in range(count)]


@pytest.mark.parametrize("limit", [1, 2, 3, 7, 8, 500])
def test_pages_are_the_whole_list_in_its_order(server: ServerUnderTest, limit: int) -> None:
    server.sign_in()
    book(server, 4)
    server.elapse(1.0)
    book(server, 3)
    whole = server.get("/rides").json()
    read = pages(server, "/rides", limit)
    assert [ride for page in read for ride in page] == whole
    assert all(len(page) == limit for page in read[:-1])
    assert read[-1]


def test_stops_come_page_by_page_in_the_order_of_the_map(server: ServerUnderTest) -> None:
    whole = server.get("/stops").json()
    assert [stop for page in pages(server, "/stops", 4) for stop in page] == whole
    assert "Link" not in server.get("/stops").headers


def test_a_ride_that_is_booked_meanwhile_neither_repeats_nor_hides_another(server: ServerUnderTest) -> None:
    server.sign_in()
    old = book(server, 4)
    first = server.get("/rides?limit=2")
    server.elapse(1.0)
    book(server, 3)
    second = server.get(first.links["next"]["url"].removeprefix("/api/v1"))
    shown = [ride["ride_id"] for page in (first, second) for ride in page.json()]
    assert shown == old[::-1]


def test_filters_go_on_to_the_next_page(server: ServerUnderTest) -> None:
    server.sign_in()
    book(server, 3)
    answer = server.get("/rides?state=refused&state=assigned&limit=2")
    assert "state=refused&state=assigned" in answer.links["next"]["url"]


def test_open_and_closed_incidents_are_one_list_in_pages(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    kinds = [IncidentKind.SEAT_BUTTON, IncidentKind.HELP_CALL, IncidentKind.TAKEOVER]
    for number in range(9):
        kind, subject = kinds[number % 3], f"subject-{number}"

        def work(uow: UnitOfWork, kind: IncidentKind = kind, subject: str = subject) -> str:
            return incidents.open_incident(uow, kind, subject, "cause").incident_id

        incident_id = server.transact(work)
        if number % 2:
            server.elapse(1.0)
            assert server.post(f"/incidents/{incident_id}/close", headers=headers).status_code == 200
    whole = server.get("/incidents?closed=true").json()
    assert len(whole) == 9
    for limit in (1, 2, 4):
        assert [one for page in pages(server, "/incidents?closed=true", limit) for one in page] == whole
    still_open = server.get("/incidents").json()
    assert [one for page in pages(server, "/incidents", 2) for one in page] == still_open


@pytest.mark.parametrize("path", ["/vehicles", "/developer-tokens", "/closures", "/series"])
def test_short_lists_have_pages_too(server: ServerUnderTest, path: str) -> None:
    headers = server.sign_in()
    series = {"from_stop": "NN7", "to_stop": "C6", "leave": "08:10", "ends_on": "2026-10-30"}
    for number in range(3):
        for made, body in (
            ("/enrolments/codes", {"vehicle_id": f"shuttle-{number}", "name": "Shuttle"}),
            ("/developer-tokens", {"name": f"token-{number}", "scopes": ["read"]}),
            ("/closures", {"lane_ids": ["east-4"]}),
            ("/series", series | {"weekdays": [0, 1, 2, 3, 4, 5, 6]}),
        ):
            assert server.post(made, body, headers=headers).status_code == 201, made
        server.elapse(1.0)
    whole = server.get(path).json()
    assert len(whole) == 3
    assert [one for page in pages(server, path, 1) for one in page] == whole


def cursor_of(*position: object) -> str:
    return base64.urlsafe_b64encode(json.dumps(position).encode()).decode().rstrip("=")


@pytest.mark.parametrize("path", LISTS)
def test_a_cursor_that_cannot_be_read_is_refused_by_every_list(server: ServerUnderTest, path: str) -> None:
    server.sign_in()
    unreadable = ["", "x", "!!!!", "bnVsbA", cursor_of(), cursor_of(1.5), cursor_of(None), cursor_of([1])]
    too_much = [cursor_of(1 << 60), cursor_of("a" * 201), cursor_of("\0"), cursor_of(1, 2, 3, 4, 5, 6)]
    for cursor in unreadable + too_much:
        answer = server.get(f"{path}{'&' if '?' in path else '?'}cursor={cursor}")
        assert (answer.status_code, answer.json()["code"]) == (400, "cursor_invalid"), cursor


@pytest.mark.parametrize("path", ["/rides", "/series", "/incidents", "/runs"])
@pytest.mark.parametrize("position", [(1,), ("ride-1", 1), (-2, "x"), (1 << 53, "x"), (1, 2, "x", 4)])
def test_a_cursor_of_another_list_is_refused(
    server: ServerUnderTest, path: str, position: tuple[object, ...]
) -> None:
    server.sign_in()
    answer = server.get(f"{path}?cursor={cursor_of(*position)}")
    assert (answer.status_code, answer.json()["code"]) == (400, "cursor_invalid")


@given(
    st.integers(0, 7_258_118_400_000_000).map(
        lambda n: datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=n)
    )
)
def test_a_moment_survives_its_cursor_to_the_microsecond(moment: datetime) -> None:
    assert moment_of(microseconds_of(moment)) == moment
