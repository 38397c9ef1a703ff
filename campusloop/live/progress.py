"""The live demo's output: a line for each shuttle and ride, and a summary at the end."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from statistics import mean
from typing import Any
from zoneinfo import ZoneInfo

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

from campusloop.clients.operator_client import ReportedRide
from campusloop.clients.passengers import ENDED
from campusloop.clients.ride_texts import promise_text

# Rides that have ended stay on screen until so many others have.
ENDED_SHOWN = 4
_SLOW = 0.1
REFRESH_PER_S = 2

Moment = Callable[[], datetime]


@dataclass(slots=True)
class Counts:
    """released: by shuttle, how often the demo's operator released it.

    lag_s: how far the campus's clock is behind the wall clock; cores: in use on average
    """

    released: dict[str, int] = field(default_factory=dict)
    lag_s: float = 0.0
    cores: float = 0.0


class DemoProgress:
    """On a terminal a table that is redrawn; elsewhere a line when a shuttle or a ride changes.

    A ride has the code under which its passenger, the console and `dispatch explain` know it.
    """

    def __init__(self, console: Console, now: Moment, zone: ZoneInfo) -> None:
        self.counts = Counts()
        self._console = console
        self._now, self._zone = now, zone
        self._vehicles: dict[str, str] = {}
        self._rides: dict[str, ReportedRide] = {}
        self._live: Live | None = None

    def __enter__(self) -> "DemoProgress":
        if self._console.is_terminal:
            self._live = Live(
                console=self._console, get_renderable=self.screen, refresh_per_second=REFRESH_PER_S
            )
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()
            self._live = None

    def say(self, text: str) -> None:
        """Print a line of its own."""
        self._console.print(text, highlight=False, soft_wrap=True)

    def vehicles(self, vehicles: list[dict[str, Any]]) -> None:
        """Show all shuttles, as the API lists them."""
        for vehicle in vehicles:
            vehicle_id, doing = vehicle["vehicle_id"], doing_of(vehicle)
            if self._live is None and doing != self._vehicles.get(vehicle_id):
                self.say(f"{self._now().astimezone(self._zone):%H:%M:%S}  {vehicle_id} {doing}")
            self._vehicles[vehicle_id] = doing if self._live is None else f"{doing}{_speed_of(vehicle)}"

    def rides(self, rides: list[ReportedRide]) -> None:
        """Show rides, as the API lists them. Those shown before stay."""
        for ride in sorted(rides, key=_requested_at):
            known = self._rides.get(ride["ride_id"])
            self._rides[ride["ride_id"]] = ride
            text = ride_text(ride, self._zone)
            if self._live is None and (known is None or text != ride_text(known, self._zone)):
                self.say(f"{self._now().astimezone(self._zone):%H:%M:%S}  ride {ride['ride_code']} {text}")

    def under_way(self) -> set[str]:
        """Ids of the shown rides that had not ended."""
        return {ride_id for ride_id, ride in self._rides.items() if ride["state"] not in ENDED}

    def newest_code(self) -> str | None:
        """Code of the ride that was requested last, of those that got a shuttle."""
        given = [ride for ride in self._rides.values() if ride["vehicle_id"]]
        return max(given, key=_requested_at)["ride_code"] if given else None

    def released(self, vehicle_id: str) -> None:
        """The demo's operator has released a shuttle after a safety stop."""
        self.counts.released[vehicle_id] = self.counts.released.get(vehicle_id, 0) + 1

    def screen(self) -> RenderableType:
        rows = Table.grid(padding=(0, 2))
        for vehicle_id, doing in sorted(self._vehicles.items()):
            rows.add_row(Text(vehicle_id, style="bold"), Text(doing))
        for ride in self._shown():
            rows.add_row(Text(f"ride {ride['ride_code']}", style="bold"), Text(ride_text(ride, self._zone)))
        return Group(rows, Text(self._footer(), style="dim"))

    def summary(self) -> list[str]:
        """The totals, in lines."""
        by_state = Counter(ride["state"] for ride in self._rides.values())
        waits = [wait_s for ride in self._rides.values() if (wait_s := _wait_s(ride)) is not None]
        states = ", ".join(f"{count} {state}" for state, count in sorted(by_state.items()))
        lines = [f"rides: {len(self._rides)} requested" + (f" ({states})" if states else "")]
        if waits:
            lines.append(f"waited: {mean(waits) / 60:.1f} min on average until aboard")
        return [*lines, self._footer()]

    def _shown(self) -> list[ReportedRide]:
        ended = [ride for ride in self._rides.values() if ride["state"] in ENDED]
        hidden = {ride["ride_id"] for ride in sorted(ended, key=_ended_at)[:-ENDED_SHOWN]}
        shown = [ride for ride_id, ride in self._rides.items() if ride_id not in hidden]
        return sorted(shown, key=_requested_at)

    def _footer(self) -> str:
        counts = self.counts
        released = sum(counts.released.values())
        times = "once" if released == 1 else f"{released} times"
        texts = [f"{counts.cores:.2f} cores used"]
        texts.append(
            f"stopped for safety and released by the demo's operator {times}"
            if released
            else "no safety stop"
        )
        if counts.lag_s >= 1.0:
            texts.append(f"the campus's clock waited {counts.lag_s:.0f} s for this machine")
        return "; ".join(texts)


def doing_of(vehicle: dict[str, Any]) -> str:
    """Where a shuttle is and what it does, as text from the API's fields."""
    status = vehicle["status"]
    if not vehicle["connected"]:
        return "is not connected"
    if status is None:
        return "is starting"
    if vehicle["held"]:
        return "is held until an operator resumes it"
    visit = next((v for v in vehicle["visits"] if v["state"] in ("under_way", "pending")), None)
    if visit is None:
        return "rests"
    place = visit["stop_id"] or "its resting place"
    if visit["state"] == "under_way":
        return f"is at {place}"
    if visit["kind"] == "rest" and abs(status["speed_mps"]) < _SLOW and not vehicle["route"]:
        return "rests"
    return f"drives to {place}"


def ride_text(ride: ReportedRide, zone: ZoneInfo) -> str:
    """A ride's stops, party and state."""
    trip = f"{ride['from_stop']} to {ride['to_stop']}, party of {ride['party']}"
    vehicle_id = ride["vehicle_id"]
    texts = {
        "requested": "waits for a shuttle",
        "assigned": f"waits for {vehicle_id}{promise_text(ride['promise'], zone)}",
        "boarding": f"boards {vehicle_id}",
        "aboard": f"is aboard {vehicle_id}",
        "completed": "has arrived",
        "no_show": "no show",
    }
    state = ride["state"]
    return f"{trip}: {texts.get(state) or _ended_text(ride)}"


def _ended_text(ride: ReportedRide) -> str:
    reason = ride["reason_detail"] or ride["reason"]
    return f"{ride['state']}: {reason}" if reason else ride["state"]


def _wait_s(ride: ReportedRide) -> float | None:
    """From the moment for which it is booked to sitting on board."""
    if ride["boarded_at"] is None:
        return None
    return (datetime.fromisoformat(ride["boarded_at"]) - _due_at(ride)).total_seconds()


def _due_at(ride: ReportedRide) -> datetime:
    return max(_requested_at(ride), datetime.fromisoformat(ride["earliest"]))


def _requested_at(ride: ReportedRide) -> datetime:
    return datetime.fromisoformat(ride["requested_at"])


def _ended_at(ride: ReportedRide) -> datetime:
    return datetime.fromisoformat(ride["ended_at"] or ride["requested_at"])


def _speed_of(vehicle: dict[str, Any]) -> str:
    status = vehicle["status"]
    if status is None or abs(status["speed_mps"]) < _SLOW:
        return ""
    return f", {3.6 * status['speed_mps']:.0f} km/h"
