"""What the live demo shows."""

import io
from datetime import UTC, datetime
from typing import Any
from zoneinfo import ZoneInfo

import pytest
from rich.console import Console

from campusloop.clients.passengers import Journey, RideDemand
from campusloop.live.progress import ENDED_SHOWN, DemoProgress, doing_of

NOW = datetime(2026, 9, 1, 8, 0, tzinfo=UTC)


def vehicle(number: int = 1, **changes: Any) -> dict[str, Any]:
    return {
        "vehicle_id": f"shuttle-{number}",
        "connected": True,
        "held": False,
        "route": ["lane-1"],
        "status": {"speed_mps": 2.5},
        "visits": [{"state": "pending", "kind": "stop", "stop_id": "stop-7"}],
    } | changes


def journey(number: int, *states: str) -> Journey:
    made = Journey(RideDemand(number, 0.0, "stop-1", "stop-2", 1, "code"), vehicle_id="shuttle-1")
    for state in states:
        made.state = state
        made.history.append((NOW, state))
    return made


def a_progress(terminal: bool = False) -> tuple[DemoProgress, io.StringIO]:
    out = io.StringIO()
    console = Console(file=out, width=100, force_terminal=terminal, color_system=None)
    return DemoProgress(console, lambda: NOW, ZoneInfo("Asia/Shanghai")), out


def shown(progress: DemoProgress) -> str:
    out = io.StringIO()
    Console(file=out, width=120).print(progress.screen())
    return out.getvalue()


@pytest.mark.parametrize(
    ("changes", "doing"),
    [
        ({}, "drives to stop-7"),
        ({"visits": [{"state": "under_way", "kind": "stop", "stop_id": "stop-7"}]}, "is at stop-7"),
        ({"visits": []}, "rests"),
        ({"visits": [{"state": "done", "kind": "stop", "stop_id": "stop-7"}]}, "rests"),
        ({"visits": [{"state": "pending", "kind": "rest", "stop_id": ""}]}, "drives to its resting place"),
        ({"held": True}, "is held until an operator resumes it"),
        ({"status": None}, "is starting"),
        ({"connected": False}, "is not connected"),
    ],
)
def test_a_shuttles_place_is_said_in_words(changes: dict[str, Any], doing: str) -> None:
    assert doing_of(vehicle(**changes)) == doing


def test_without_a_terminal_a_shuttle_gets_a_line_when_it_does_something_else() -> None:
    progress, out = a_progress()
    with progress:
        progress.vehicles([vehicle(1), vehicle(2)])
        progress.vehicles([vehicle(1, status={"speed_mps": 1.0}), vehicle(2, visits=[])])
    assert out.getvalue().splitlines() == [
        "16:00:00  shuttle-1 drives to stop-7",
        "16:00:00  shuttle-2 drives to stop-7",
        "16:00:00  shuttle-2 rests",
    ]


def test_without_a_terminal_a_ride_gets_a_line_at_each_state() -> None:
    progress, out = a_progress()
    with progress:
        progress.ride(journey(1, "requested"))
        progress.ride(journey(1, "requested", "aboard"))
    assert [line.split("  ")[1] for line in out.getvalue().splitlines()] == [
        "ride 1 requested: stop-1 to stop-2, party of 1",
        "ride 1 is aboard shuttle-1 (code)",
    ]


def test_the_screen_has_one_line_for_each_shuttle_and_ride() -> None:
    progress, _ = a_progress(terminal=True)
    with progress:
        for _ in range(3):
            progress.vehicles([vehicle(1), vehicle(2)])
            progress.ride(journey(1, "requested", "assigned"))
        lines = shown(progress).splitlines()
    assert [line.split()[0] for line in lines[:3]] == ["shuttle-1", "shuttle-2", "ride"]
    assert "drives to stop-7, 9 km/h" in lines[0]
    assert "stop-1 to stop-2, party of 1: waits for shuttle-1" in lines[2]
    assert len(lines) == 4


def test_rides_that_have_ended_leave_the_screen_after_a_while() -> None:
    progress, _ = a_progress(terminal=True)
    for number in range(1, 10):
        progress.ride(journey(number, "requested", "completed"))
    progress.ride(journey(10, "requested"))
    lines = [line for line in shown(progress).splitlines() if line.startswith("ride")]
    assert len(lines) == ENDED_SHOWN + 1


def test_releases_are_counted_and_no_line_each() -> None:
    progress, out = a_progress()
    with progress:
        for _ in range(3):
            progress.released("shuttle-1")
    assert out.getvalue() == ""
    assert "3 times" in progress.summary()[-1]


def test_the_summary_counts_rides_by_how_they_ended() -> None:
    progress, _ = a_progress()
    progress.ride(journey(1, "requested", "aboard", "completed"))
    progress.ride(journey(2, "requested"))
    progress.counts.lag_s = 12.0
    lines = progress.summary()
    assert lines[0] == "rides: 2 requested (1 completed, 1 requested)"
    assert "no safety stop" in lines[-1]
    assert "the campus's clock waited 12 s for this machine" in lines[-1]
