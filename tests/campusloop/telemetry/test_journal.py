"""An error in the journal tells where it happened, in every format, and not what the variables held."""

import io
import re
import sys
from collections.abc import Iterator

import pytest
import structlog

from tests.campusloop.telemetry.restored_journal import restored_journal
from vehicle_agent.runtime.processes.journal import write_journal

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
