"""Announcements over REST, and on the socket of a board."""

import json

import pytest

from tests.server.api.server_under_test import ServerUnderTest
from tests.server.api.sockets.test_board_socket import opened

BODY = {"text_zh": "今天在东侧上车", "text_en": "Board at the east side today"}


def test_an_announcement_is_made_read_by_everybody_listed_and_ended(server: ServerUnderTest) -> None:
    operator = server.sign_in()
    made = server.post("/announcements", BODY, headers=operator)
    assert made.status_code == 201, made.text
    view = made.json()
    assert (view["state"], view["made_by"], view["audience"]) == ("current", "operator", "all")
    (read,) = server.request("GET", "/announcements/current").json()
    assert read == {name: view[name] for name in read}
    assert not {"made_by", "ended_by"} & read.keys(), "riders need not know who wrote it"
    ended = server.post(f"/announcements/{view['announcement_id']}/end", headers=operator)
    assert (ended.status_code, ended.json()["state"], ended.json()["ended_by"]) == (200, "over", "operator")
    assert server.request("GET", "/announcements/current").json() == []
    assert server.get("/announcements").json() == [ended.json()]
    again = server.post(f"/announcements/{view['announcement_id']}/end", headers=operator)
    assert (again.status_code, again.json()["code"]) == (409, "announcement_over")
    logged = server.get("/audit").json()
    assert {"make_announcement", "end_announcement"} <= {one["action"] for one in logged}


@pytest.mark.parametrize(
    ("changes", "status", "code"),
    [
        ({"text_en": " "}, 422, "payload_invalid"),
        ({"text_zh": "字" * 281}, 422, "payload_invalid"),
        (
            {"starts_at": "2026-09-03T08:00:00Z", "ends_at": "2026-09-03T07:00:00Z"},
            400,
            "announcement_invalid",
        ),
        ({"audience": "stops", "stop_ids": ["nowhere"]}, 404, "stop_unknown"),
        ({"audience": "shuttles", "vehicle_ids": ["ghost"]}, 404, "vehicle_unknown"),
        ({"audience": "riders"}, 422, "payload_invalid"),
    ],
)
def test_bad_input_is_refused_with_its_reason(
    server: ServerUnderTest, changes: dict[str, object], status: int, code: str
) -> None:
    answer = server.post("/announcements", BODY | changes, headers=server.sign_in())
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert server.get("/announcements").json() == []


def test_an_open_board_shows_it_and_takes_it_down_by_itself(server: ServerUnderTest) -> None:
    stop_id = server.get("/stops").json()[0]["stop_id"]
    screen = opened(server, stop_id)
    operator = server.sign_in()
    made = server.post(
        "/announcements", BODY | {"audience": "stops", "stop_ids": [stop_id]}, headers=operator
    )
    server.elapse(1.5)
    shown = json.loads(screen.texts[-1])["announcements"]
    assert [one["text_en"] for one in shown] == [BODY["text_en"]]
    server.post(f"/announcements/{made.json()['announcement_id']}/end", headers=operator)
    server.elapse(1.5)
    assert json.loads(screen.texts[-1])["announcements"] == []
    screen.leave()
