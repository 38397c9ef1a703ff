"""The live demo's output: a line for each shuttle and ride, and a summary at the end."""

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

from campusloop.clients.passengers import ENDED, Journey
from campusloop.virtual.headless import timeline_line

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
    """On a terminal a table that is redrawn; elsewhere a line when a shuttle or a ride changes."""

    def __init__(self, console: Console, now: Moment, zone: ZoneInfo) -> None:
        self.counts = Counts()
        self._console = console
        self._now, self._zone = now, zone
        self._vehicles: dict[str, str] = {}
        self._journeys: dict[int, Journey] = {}
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

    def ride(self, journey: Journey) -> None:
        """A ride's state has changed."""
        self._journeys[journey.demand.number] = journey
        if self._live is None:
            self.say(timeline_line(journey, self._now(), self._zone))

    def vehicles(self, vehicles: list[dict[str, Any]]) -> None:
        """Show all shuttles, as the API lists them."""
        for vehicle in vehicles:
            vehicle_id, doing = vehicle["vehicle_id"], doing_of(vehicle)
            if self._live is None and doing != self._vehicles.get(vehicle_id):
                self.say(f"{self._now().astimezone(self._zone):%H:%M:%S}  {vehicle_id} {doing}")
            self._vehicles[vehicle_id] = doing if self._live is None else f"{doing}{_speed_of(vehicle)}"

    def released(self, vehicle_id: str) -> None:
        """The demo's operator has released a shuttle after a safety stop."""
        self.counts.released[vehicle_id] = self.counts.released.get(vehicle_id, 0) + 1

    def screen(self) -> RenderableType:
        rows = Table.grid(padding=(0, 2))
        for vehicle_id, doing in sorted(self._vehicles.items()):
            rows.add_row(Text(vehicle_id, style="bold"), Text(doing))
        for journey in self._shown():
            rows.add_row(Text(f"ride {journey.demand.number}", style="bold"), Text(ride_text(journey)))
        return Group(rows, Text(self._footer(), style="dim"))

    def summary(self) -> list[str]:
        """The totals, in lines."""
        by_state: dict[str, int] = {}
        for journey in self._journeys.values():
            by_state[journey.state] = by_state.get(journey.state, 0) + 1
        waits = [j.wait_s for j in self._journeys.values() if j.wait_s is not None]
        requested = len(self._journeys)
        states = ", ".join(f"{count} {state}" for state, count in sorted(by_state.items()))
        lines = [f"rides: {requested} requested" + (f" ({states})" if states else "")]
        if waits:
            lines.append(f"waited: {mean(waits) / 60:.1f} min on average until aboard")
        return [*lines, self._footer()]

    def _shown(self) -> list[Journey]:
        ended = [number for number, journey in self._journeys.items() if journey.state in ENDED]
        hidden = set(ended[:-ENDED_SHOWN])
        return [journey for number, journey in sorted(self._journeys.items()) if number not in hidden]

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


def ride_text(journey: Journey) -> str:
    """A ride's line on the screen."""
    demand = journey.demand
    trip = f"{demand.from_stop} to {demand.to_stop}, party of {demand.party}"
    texts = {
        "requested": "requests a ride",
        "assigned": f"waits for {journey.vehicle_id}",
        "boarding": f"boards {journey.vehicle_id}",
        "aboard": f"is aboard {journey.vehicle_id}",
        "completed": "has arrived",
    }
    return f"{trip}: {texts.get(journey.state, f'{journey.state} {journey.reason}')}"


def _speed_of(vehicle: dict[str, Any]) -> str:
    status = vehicle["status"]
    if status is None or abs(status["speed_mps"]) < _SLOW:
        return ""
    return f", {3.6 * status['speed_mps']:.0f} km/h"
