"""A stop board over REST: open to all, with a code that leads to a booking from the stop."""

import json
from pathlib import Path

from tests.server.api.server_under_test import ServerUnderTest


def test_a_board_names_the_stop_and_where_to_book_and_no_rider(server: ServerUnderTest) -> None:
    board = server.get("/stops/NN20/board").json()
    assert board["stop"]["stop_id"] == "NN20"
    assert board["book_url"] == "http://campus.test/?from=NN20"
    assert not {"ride_id", "ride_code", "party"} & set(json.dumps(board).split('"'))
    assert all(row["to_name"] for row in board["departures"])


def test_the_code_is_a_picture_of_the_address(server: ServerUnderTest) -> None:
    code = server.get("/stops/NN20/board/code")
    assert (code.status_code, code.headers["content-type"]) == (200, "image/svg+xml")
    assert code.content.startswith(b"<?xml")
    assert code.content != server.get("/stops/C6/board/code").content


def test_the_address_is_the_one_of_the_settings(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, public_url="https://campus.example/")
    assert server.get("/stops/NN20/board").json()["book_url"] == "https://campus.example/?from=NN20"
    server.close()


def test_a_stop_that_is_none_has_neither(server: ServerUnderTest) -> None:
    for path in ("/stops/nowhere/board", "/stops/nowhere/board/code"):
        answer = server.get(path)
        assert (answer.status_code, answer.json()["code"]) == (404, "stop_unknown")
