"""The end of a server that cannot do its work, also where nothing can be written any more."""

import io
import threading

import pytest
import uvicorn
from rich.console import Console

from campusloop.live.process_end import CANNOT_WORK, END_WITHIN_S, ProcessEnd


class FullDisk(io.StringIO):
    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")


@pytest.fixture
def timers(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, object]]:
    """What would end the process, and when: this one goes on."""
    asked: list[tuple[float, object]] = []

    class NotedTimer(threading.Thread):
        def __init__(self, interval: float, function: object, args: tuple[int, ...]) -> None:
            super().__init__(target=asked.append, args=((interval, args),))

    monkeypatch.setattr(threading, "Timer", NotedTimer)
    return asked


def a_server() -> uvicorn.Server:
    return uvicorn.Server(uvicorn.Config("no:app"))


@pytest.mark.parametrize("file", [io.StringIO(), FullDisk()])
def test_the_server_is_told_to_stop_and_is_ended_if_it_hangs(
    timers: list[tuple[float, object]], file: io.StringIO
) -> None:
    server, end = a_server(), ProcessEnd(Console(file=file))
    end.stops(server)
    assert not server.should_exit
    end.demand("dispatcher has failed 12 times", OSError("disk full"))
    assert server.should_exit
    assert end.text == "dispatcher has failed 12 times"
    for thread in threading.enumerate():
        if type(thread).__name__ == "NotedTimer":
            thread.join(5.0)
    assert timers == [(END_WITHIN_S, (CANNOT_WORK,))]


def test_an_end_that_was_demanded_before_there_was_a_server_is_not_forgotten(
    timers: list[tuple[float, object]],
) -> None:
    server, end = a_server(), ProcessEnd(Console(file=io.StringIO()))
    end.demand("no database", OSError("gone"))
    end.stops(server)
    assert server.should_exit


def test_the_first_cause_stays_the_last_word(timers: list[tuple[float, object]]) -> None:
    said = io.StringIO()
    end = ProcessEnd(Console(file=said, width=200))
    end.demand("the first", OSError("a"))
    end.demand("the second", OSError("b"))
    assert end.text == "the first"
    assert said.getvalue() == "campusloop serve ends: the first\n"
