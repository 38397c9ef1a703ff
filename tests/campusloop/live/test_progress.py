"""What the live demo shows."""

import io
from datetime import UTC, datetime
from typing import Any, cast
from zoneinfo import ZoneInfo

import pytest
from rich.console import Console

from campusloop.clients.operator_client import ReportedRide
from campusloop.clients.passengers import ENDED
from campusloop.live.progress import ENDED_SHOWN, DemoProgress, doing_of, ride_text

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


def ride(number: int = 1, state: str = "assigned", **changes: Any) -> ReportedRide:
    """Requested one minute after the other; the API's fields."""
    moment = f"2026-09-01T08:{number:02}"
    fields: dict[str, Any] = {
        "ride_id": f"ride-{number}",
        "ride_code": f"CODE{number:02}",
        "state": state,
        "from_stop": "stop-1",
        "to_stop": "stop-2",
        "party": 2,
        "earliest": f"{moment}:00Z",
        "requested_at": f"{moment}:00Z",
        "promise": None,
        "vehicle_id": "shuttle-1",
        "boarded_at": None,
        "ended_at": f"{moment}:30Z" if state in ENDED else None,
        "reason": "",
        "reason_detail": "",
    }
    return cast(ReportedRide, fields | changes)


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


PROMISE = {
    "pickup_from": "2026-09-01T08:17:00Z",
    "pickup_to": "2026-09-01T08:23:00Z",
    "arrive_by": "2026-09-01T08:34:00Z",
}


@pytest.mark.parametrize(
    ("state", "changes", "said"),
    [
        ("requested", {"vehicle_id": None}, "waits for a shuttle"),
        ("assigned", {}, "waits for shuttle-1"),
        (
            "assigned",
            {"promise": PROMISE},
            "waits for shuttle-1, pickup 16:17-16:23, there by 16:34",
        ),
        ("boarding", {}, "boards shuttle-1"),
        ("aboard", {}, "is aboard shuttle-1"),
        ("completed", {}, "has arrived"),
        ("no_show", {}, "no show"),
        ("cancelled", {}, "cancelled"),
        ("refused", {"reason": "fleet_full"}, "refused: fleet_full"),
        (
            "failed",
            {"reason": "vehicle_lost", "reason_detail": "the shuttle is gone"},
            "failed: the shuttle is gone",
        ),
    ],
)
def test_a_rides_state_is_said_in_words(state: str, changes: dict[str, Any], said: str) -> None:
    text = ride_text(ride(1, state, **changes), ZoneInfo("Asia/Shanghai"))
    assert text == f"stop-1 to stop-2, party of 2: {said}"


def test_without_a_terminal_a_ride_gets_a_line_when_it_changes() -> None:
    progress, out = a_progress()
    with progress:
        progress.rides([ride(2, "requested"), ride(1)])
        progress.rides([ride(2, "requested"), ride(1)])
        progress.rides([ride(2), ride(1)])
    assert out.getvalue().splitlines() == [
        "16:00:00  ride CODE01 stop-1 to stop-2, party of 2: waits for shuttle-1",
        "16:00:00  ride CODE02 stop-1 to stop-2, party of 2: waits for a shuttle",
        "16:00:00  ride CODE02 stop-1 to stop-2, party of 2: waits for shuttle-1",
    ]


def test_the_screen_has_one_line_for_each_shuttle_and_ride() -> None:
    progress, _ = a_progress(terminal=True)
    with progress:
        for _ in range(3):
            progress.vehicles([vehicle(1), vehicle(2)])
            progress.rides([ride(2, "aboard"), ride(1)])
        lines = shown(progress).splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["shuttle-1", "shuttle-2", "ride", "ride"]
    assert "drives to stop-7, 9 km/h" in lines[0]
    assert "CODE01  stop-1 to stop-2, party of 2: waits for shuttle-1" in lines[2]
    assert "CODE02  stop-1 to stop-2, party of 2: is aboard shuttle-1" in lines[3]
    assert len(lines) == 5


def test_the_rides_that_ended_last_stay_on_the_screen() -> None:
    progress, _ = a_progress(terminal=True)
    ended = [ride(number, "completed") for number in range(1, 10)]
    ended[0] = ride(1, "completed", ended_at="2026-09-01T09:00:00Z")
    progress.rides([*ended, ride(10)])
    codes = [line.split()[1] for line in shown(progress).splitlines() if line.startswith("ride")]
    assert codes == ["CODE01", *(f"CODE{number:02}" for number in range(11 - ENDED_SHOWN, 11))]


def test_a_ride_that_the_newest_list_has_no_room_for_is_still_followed() -> None:
    progress, _ = a_progress(terminal=True)
    progress.rides([ride(1), ride(2, "completed")])
    progress.rides([ride(3)])
    assert progress.under_way() == {"ride-1", "ride-3"}
    assert "CODE01" in shown(progress)


def test_releases_are_counted_and_no_line_each() -> None:
    progress, out = a_progress()
    with progress:
        for _ in range(3):
            progress.released("shuttle-1")
    assert out.getvalue() == ""
    assert "3 times" in progress.summary()[-1]


def test_the_summary_counts_all_rides_by_how_they_ended() -> None:
    progress, _ = a_progress()
    progress.rides([ride(1, "aboard", boarded_at="2026-09-01T08:05:00Z"), ride(2, "requested"), ride(3)])
    progress.rides([ride(1, "completed", boarded_at="2026-09-01T08:05:00Z")])
    progress.counts.lag_s = 12.0
    lines = progress.summary()
    assert lines[0] == "rides: 3 requested (1 assigned, 1 completed, 1 requested)"
    assert lines[1] == "waited: 4.0 min on average until aboard"
    assert "no safety stop" in lines[-1]
    assert "the campus's clock waited 12 s for this machine" in lines[-1]


def test_who_books_for_later_has_not_waited_before() -> None:
    progress, _ = a_progress()
    booked = {"earliest": "2026-09-01T08:30:00Z", "boarded_at": "2026-09-01T08:33:00Z"}
    progress.rides([ride(1, "aboard", **booked)])
    assert progress.summary()[1] == "waited: 3.0 min on average until aboard"


def test_without_rides_the_summary_says_so() -> None:
    progress, _ = a_progress()
    assert progress.summary()[0] == "rides: 0 requested"
    assert len(progress.summary()) == 2


def test_the_newest_ride_that_got_a_shuttle_is_the_one_to_explain() -> None:
    progress, _ = a_progress()
    assert progress.newest_code() is None
    progress.rides([ride(1), ride(3, "refused", vehicle_id=None), ride(2, "completed")])
    assert progress.newest_code() == "CODE02"
