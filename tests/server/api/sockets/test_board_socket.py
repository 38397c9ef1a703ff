"""The board of a stop over its socket: whenever it changes, and as the page would read it."""

import json

from tests.server.api.server_under_test import ServerUnderTest
from tests.server.api.sockets.open_socket import OpenSocket

NO_HEADER = (b"accept", b"*/*")


def opened(server: ServerUnderTest, stop_id: str) -> OpenSocket:
    return OpenSocket(server, f"/ws/board/{stop_id}", NO_HEADER)


def test_a_board_comes_at_once_and_again_when_a_road_at_the_stop_is_closed(server: ServerUnderTest) -> None:
    stop = server.get("/stops").json()[0]
    lane_id = server.transact(lambda uow: uow.network().stops[stop["stop_id"]].lane_id)
    screen = opened(server, stop["stop_id"])
    (first,) = [json.loads(text) for text in screen.texts]
    now = {"now": first["now"], "opens_next": first["opens_next"]}
    assert first | now == server.get(f"/stops/{stop['stop_id']}/board").json() | now
    assert first["closures"] == []
    operator = server.sign_in()
    closed = server.post("/closures", {"lane_ids": [lane_id], "reason": "Road works"}, headers=operator)
    assert closed.status_code == 201, closed.text
    server.elapse(1.5)
    newest = json.loads(screen.texts[-1])
    assert [one["reason"] for one in newest["closures"]] == ["Road works"]
    count = len(screen.texts)
    server.elapse(6.0)
    assert len(screen.texts) > count, "a screen must know that the connection lives"
    screen.leave()
    assert screen.task.done()


def test_a_stop_that_the_map_does_not_have_closes_the_socket(server: ServerUnderTest) -> None:
    screen = opened(server, "nowhere")
    assert (screen.closed, screen.texts) == (4404, [])
