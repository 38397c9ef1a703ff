"""An error in the journal tells where it happened, in every format, and not what the variables held."""

import io
import json
import logging
import re
import sys
from collections.abc import Iterator

import pytest
import structlog

from tests.campusloop.telemetry.restored_journal import restored_journal
from vehicle_agent.runtime.processes.journal import run_logged, write_journal

TOKEN = "q3Jv0X2mQp7sT4uYb1cD9w"


@pytest.fixture(params=[True, False], ids=["terminal", "lines"])
def journal(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[io.StringIO]:
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: request.param, raising=False)
    monkeypatch.setattr(sys, "stderr", stream)
    with restored_journal():
        write_journal("server")
        yield stream


def fail_with(token: str) -> None:
    raise ValueError(f"{len(token)} characters")


def test_a_traceback_names_the_place_and_holds_no_variable(journal: io.StringIO) -> None:
    log, ticket = structlog.get_logger(), {"token": TOKEN}
    try:
        fail_with(ticket["token"])
    except ValueError:
        log.exception("task.failed")
    said = re.sub(r"\x1b\[[0-9;]*m", "", journal.getvalue())
    assert "fail_with" in said
    assert "22 characters" in said
    assert TOKEN not in said


def test_a_library_with_a_handler_of_its_own_logs_in_the_same_format() -> None:
    stream, library = io.StringIO(), logging.getLogger("a_library")
    library.addHandler(logging.StreamHandler())
    library.propagate = False
    with restored_journal():
        write_journal("server", stream)
        library.warning("something %s", "odd")
    fields = [json.loads(line) for line in stream.getvalue().splitlines()]
    assert [list(one)[:4] for one in fields] == [["timestamp", "level", "event", "process"]] * len(fields)
    assert (fields[0]["event"], fields[0]["logger"], fields[0]["level"]) == (
        "something odd",
        "a_library",
        "warning",
    )
    assert fields[0]["process"] == "server"


def test_numbers_that_json_does_not_have_are_texts() -> None:
    stream = io.StringIO()
    with restored_journal():
        write_journal("tick", stream)
        structlog.get_logger().info("tick.late", late_ms=float("nan"), at=Exception("x"))
    assert json.loads(stream.getvalue(), parse_constant=lambda _: 1 / 0)["late_ms"] == "nan"


def test_an_error_of_a_whole_process_is_a_line_and_ends_it_with_1() -> None:
    stream = io.StringIO()
    with restored_journal():
        write_journal("tick", stream)
        with pytest.raises(SystemExit) as ended:
            run_logged(fail_with, "abc")
    assert ended.value.code == 1
    said = json.loads(stream.getvalue())
    assert (said["event"], said["level"]) == ("process.failed", "critical")
    assert said["exception"][0]["exc_value"] == "3 characters"
