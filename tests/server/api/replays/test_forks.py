"""Forks of the past over REST: who may, what is refused, and that nothing changes."""

import pytest

from server.domain.instants import ms_of
from server.domain.record.identity import Role
from tests.server.api.rides.test_rides import book
from tests.server.api.security.test_roles import headers_of
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.api.vehicles.test_commands import a_shuttle

FORK = "/replays/forks"


@pytest.fixture
def booked(server: ServerUnderTest) -> tuple[ServerUnderTest, int]:
    """One shuttle and one ride that waits; the moment at which it does."""
    a_shuttle(server, "shuttle-1")
    book(server)
    server.elapse(10.0)
    return server, ms_of(server.services.clock.now())


def test_a_fork_is_computed_and_changes_nothing(booked: tuple[ServerUnderTest, int]) -> None:
    server, at_ms = booked
    headers = server.sign_in()
    before = server.get("/rides").json()
    request = {"from_ms": at_ms, "more": 1, "policy": "insertion"}
    answer = server.post(FORK, request, headers=headers)
    assert answer.status_code == 200, answer.text
    fork = answer.json()
    assert (fork["present"]["shuttles"], fork["changed"]["shuttles"], fork["placed"]) == (1, 2, 1)
    (ride,) = fork["rides"]
    assert (ride["ride_id"], ride["present_end"], ride["then_wait_s"]) == (
        before[0]["ride_id"],
        "served",
        None,
    )
    assert ride["present_wait_s"] >= 10.0 - 1.0
    assert server.get("/rides").json() == before
    assert server.post(FORK, request, headers=headers).json() == fork


def test_a_moment_without_rides_is_refused_with_the_reason(server: ServerUnderTest) -> None:
    a_shuttle(server, "shuttle-1")
    at_ms = ms_of(server.services.clock.now())
    answer = server.post(FORK, {"from_ms": at_ms}, headers=server.sign_in())
    assert (answer.status_code, answer.json()["code"]) == (409, "fork_impossible")
    assert "no ride waited" in answer.json()["detail"]


@pytest.mark.parametrize("wrong", [{"more": 51}, {"policy": "magic"}, {"seconds": 10**7}, {"from_ms": -1}])
def test_input_that_is_none_is_refused(server: ServerUnderTest, wrong: dict[str, object]) -> None:
    answer = server.post(FORK, {"from_ms": 0} | wrong, headers=server.sign_in())
    assert answer.status_code == 422


@pytest.mark.parametrize(("role", "status"), [("viewer", 403), ("dispatcher", 200), ("safety", 200)])
def test_who_may_fork(booked: tuple[ServerUnderTest, int], role: Role, status: int) -> None:
    server, at_ms = booked
    answer = server.post(FORK, {"from_ms": at_ms}, headers=headers_of(server, frozenset({role})))
    assert answer.status_code == status
