"""`campusloop rides` against a server that runs, and where none does."""

import asyncio
import json
import socket
import sys
from pathlib import Path
from typing import get_args

import pytest
from typer.testing import CliRunner, Result

from campusloop.cli import app_of
from campusloop.commands.rides import STATES
from campusloop_sdk.models import RideState
from tests.campusloop.live.live_server import LiveServer, obedient_vehicle
from tests.sdk.campus_scripts import against_server

RUN = CliRunner()


def rides(*arguments: str, server: str = "", token: str = "t0ken") -> Result:
    environment = {"CAMPUSLOOP_SERVER": server or None, "CAMPUSLOOP_TOKEN": token}
    return RUN.invoke(app_of(("rides",)), ["rides", *arguments], env=environment)


async def asked(server: LiveServer, token: str, *arguments: str) -> Result:
    """While the server of this event loop answers."""
    return await asyncio.to_thread(rides, *arguments, server=server.origin, token=token)


def test_a_ride_is_booked_shown_listed_and_cancelled(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        token, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server):
            booked = await asked(server, token, "book", "NN20", "C6", "--party", "2")
            assert booked.exit_code == 0, booked.output
            told = {line[:10].strip(): line[10:] for line in booked.stdout.splitlines()}
            assert (told["state"], told["party"]) == ("assigned", "2")
            assert "shuttle-1" in told["shuttle"]
            assert told["shuttle"].endswith(" seats left")
            assert " to " in told["expected"]
            assert "there by" in told["promised"]
            ride_id = told["ride"].split()[0]
            shown = json.loads((await asked(server, token, "show", ride_id, "--json")).stdout)
            assert (shown["ride_id"], shown["from_stop"], shown["to_stop"]) == (ride_id, "NN20", "C6")
            cancelled = await asked(server, token, "cancel", ride_id)
            assert cancelled.exit_code == 0, cancelled.output
            assert "cancelled" in cancelled.stdout
            (listed,) = (await asked(server, token, "list", "--state", "cancelled")).stdout.splitlines()
            assert listed.startswith(ride_id)
            assert (await asked(server, token, "list", "--state", "assigned")).stdout == ""

    against_server(tmp_path, claim)


def test_a_ride_is_shown_and_cancelled_by_its_code_while_it_is_open(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        token, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server):
            booked = json.loads((await asked(server, token, "book", "NN20", "C6", "--json")).stdout)
            code = booked["ride_code"]
            shown = json.loads((await asked(server, token, "show", code.lower(), "--json")).stdout)
            assert shown["ride_id"] == booked["ride_id"]
            cancelled = await asked(server, token, "cancel", code)
            assert cancelled.exit_code == 0, cancelled.output
            for arguments in (("cancel", code), ("show", "ZZZZZZ"), ("cancel", booked["boarding_code"])):
                refused = await asked(server, token, *arguments)
                assert refused.exit_code == 2, refused.output

    against_server(tmp_path, claim)


def test_a_refused_booking_ends_with_1_and_a_repeat_with_the_same_key_books_nothing(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        token, _ = await server.developer_token("read", "drive")
        # No shuttle is there.
        for _ in range(2):
            refused = await asked(server, token, "book", "NN20", "C6", "--key", "morning-1")
            assert refused.exit_code == 1, refused.output
            assert "refused: " in refused.stdout
        assert len(json.loads((await asked(server, token, "list", "--json")).stdout)) == 1
        await asked(server, token, "book", "NN20", "C6")
        assert len((await asked(server, token, "list")).stdout.splitlines()) == 2
        assert len((await asked(server, token, "list", "--limit", "1")).stdout.splitlines()) == 1

    against_server(tmp_path, claim)


def test_what_the_server_refuses_ends_with_2_and_what_to_do(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        reader, _ = await server.developer_token("read")
        for token, arguments, remedy in (
            (reader, ("book", "NN20", "C6"), "campusloop token create"),
            ("wrong", ("list",), "campusloop token create"),
            (reader, ("show", "ride-9"), "ride-9"),
        ):
            done = await asked(server, token, *arguments)
            assert done.exit_code == 2, done.output
            assert remedy in done.stderr
            assert done.stdout == ""

    against_server(tmp_path, claim)


def test_where_no_server_answers_it_says_so_and_what_to_do() -> None:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        origin = f"http://127.0.0.1:{unused.getsockname()[1]}"
        done = rides("list", server=origin)
    assert done.exit_code == 2, done.output
    assert f"no server answers at {origin}" in done.stderr
    assert "campusloop demo" in done.stderr
    assert "t0ken" not in done.output


@pytest.mark.parametrize(
    ("arguments", "token", "remedy"),
    [
        (["list"], "", "set CAMPUSLOOP_TOKEN"),
        (["list"], "t0k\N{EN DASH}n", "copy it again"),
        (["list", "--server", "localhost:8080"], "t", "http://HOST:PORT"),
        (["list", "--state", "lost"], "t", "no_show"),
        (["list", "--certificate", "nowhere.pem"], "t", "nowhere.pem"),
        (["book", "a", "b", "--at", "tomorrow"], "t", "2026-12-01T08:30+08:00"),
        (["book", "a", "b", "--at", "2026-12-01T08:30"], "t", "no time zone"),
    ],
)
def test_bad_input_ends_with_2_and_what_to_do(arguments: list[str], token: str, remedy: str) -> None:
    done = rides(*arguments, token=token)
    assert done.exit_code == 2, done.output
    assert remedy in done.stderr


def test_without_the_package_for_developers_it_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "campusloop_sdk"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [])
    done = rides("list")
    assert done.exit_code == 2, done.output
    assert "pip install ./sdk/python" in done.stderr


def test_the_states_are_those_of_the_package_for_developers() -> None:
    assert get_args(RideState) == STATES
