"""`campusloop demo --headless`: the main job in virtual time, as fast as the machine allows, with its proof.

Rides are booked by simulated passengers, driven through people by the real onboard loop, and every run is
replayed at the end. Nothing is taken on trust: the summary comes from ground truth and from run logs.
"""

import time
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING
from zoneinfo import ZoneInfo

import numpy as np
from rich.console import Console
from rich.table import Table

from campusloop.clients.passengers import Journey
from campusloop.clients.ride_demand import RIDE_M_MAX, RIDE_M_MIN, random_rides, stop_pairs
from campusloop.virtual.run_proof import RunProof, SpacedWord, flaws, virtual_progress

if TYPE_CHECKING:
    from campusloop.virtual.campus import CampusOptions, VirtualCampus

SPACING_S = 90.0
RIDE_TIMEOUT_S = 3600.0
STEPS_PER_REFRESH = 250


@dataclass(frozen=True, slots=True)
class DemoResult:
    journeys: list[Journey]
    failures: list[str]


class RideScores:
    """What a vehicle's score was when a ride began and when it ended."""

    def __init__(self, campus: "VirtualCampus") -> None:
        self._campus = campus
        self._begun: dict[int, tuple[float, int]] = {}
        self._ended: dict[int, tuple[float, int]] = {}

    def note(self, journey: Journey) -> None:
        if journey.state in ("aboard", "completed"):
            score = self._campus.world.score(journey.vehicle_id)
            at = self._begun if journey.state == "aboard" else self._ended
            at[journey.wish.number] = (score.distance_m, score.encounters)

    def distance_m(self, journey: Journey) -> float | None:
        number = journey.wish.number
        return self._ended[number][0] - self._begun[number][0] if number in self._ended else None

    def encounters(self, journey: Journey) -> int:
        number = journey.wish.number
        return self._ended[number][1] - self._begun[number][1] if number in self._ended else 0


def run_headless(
    options: "CampusOptions",
    rides: int,
    console: Console,
    pairs: list[tuple[str, str]] | None = None,
    spacing_s: float = SPACING_S,
) -> DemoResult:
    """Run the campus until every ride has ended, replay every run, print the summary.

    pairs: the stops of rides to choose from; by default all that are a good ride apart
    spacing_s: mean time between two passengers who ask
    """
    # It brings the whole server along, which the live demo's own process has no use for.
    from campusloop.virtual.campus import START_NS, VirtualCampus

    started = time.perf_counter()
    console.print(
        f"building the campus: {options.road_map.name}, {options.vehicles} shuttles", highlight=False
    )
    campus = VirtualCampus(options)
    clock = ZoneInfo(options.road_map.timezone)

    scores = RideScores(campus)

    def tell(journey: Journey) -> None:
        scores.note(journey)
        console.print(timeline_line(journey, campus.now(), clock), highlight=False, soft_wrap=True)

    campus.start()
    pairs = pairs or stop_pairs(options.road_map, RIDE_M_MIN, RIDE_M_MAX)
    wanted = random_rides(rides, pairs, spacing_s, campus.conductor.rng("passengers"))
    passengers = campus.passengers(tell)
    tasks = [campus.conductor.loop.create_task(passengers.live(Journey(wish))) for wish in wanted]
    with RunProof(options.folder) as proof:
        with virtual_progress(console) as progress:
            bar = progress.add_task("rides", total=rides, clock="")
            deadline_ns = campus.conductor.now_ns + round(RIDE_TIMEOUT_S * 1e9)
            word = SpacedWord(console)
            while not all(task.done() for task in tasks) and campus.conductor.now_ns < deadline_ns:
                for _ in range(STEPS_PER_REFRESH):
                    campus.conductor.step()
                proof.look()
                done = sum(task.done() for task in tasks)
                pace = (campus.conductor.now_ns - START_NS) / 1e9 / (time.perf_counter() - started)
                doing = f"{campus.now().astimezone(clock):%H:%M:%S}, {pace:.1f} x"
                progress.update(bar, completed=done, clock=f"{doing}, {driving(campus)}")
                word.say(f"{doing}  {done} of {rides} rides have ended; {driving(campus)}")
        virtual_s = (campus.conductor.now_ns - START_NS) / 1e9
        campus.stop()
        wall_s = time.perf_counter() - started
        proofs = proof.results(console)
    journeys = [task.result() for task in tasks if task.done()]
    failures = [
        f"ride {wish.number} did not end" for wish, task in zip(wanted, tasks, strict=True) if not task.done()
    ]
    failures += [
        f"ride {j.wish.number} ended as {j.state} ({j.reason})" for j in journeys if j.state != "completed"
    ]
    failures += contacts(campus)
    failures += flaws(proofs)
    print_summary(console, campus, journeys, scores)
    ticks = sum(proof.ticks for proof in proofs)
    console.print(
        f"{virtual_s:.0f} virtual s in {wall_s:.0f} s wall ({virtual_s / wall_s:.1f} x); "
        f"{len(proofs)} segments with {ticks} ticks replayed; "
        f"{time.perf_counter() - started:.0f} s in all"
    )
    return DemoResult(journeys, failures)


def contacts(campus: "VirtualCampus") -> list[str]:
    """Whoever touched anybody or anything, by ground truth."""
    scores = {vehicle_id: campus.world.score(vehicle_id) for vehicle_id in campus.vehicles}
    return [f"{name} made {score.contacts} contacts" for name, score in scores.items() if score.contacts]


def driving(campus: "VirtualCampus") -> str:
    """How far each shuttle has come, by ground truth."""
    return ", ".join(f"{name} {campus.world.score(name).distance_m:.0f} m" for name in campus.vehicles)


def timeline_line(journey: Journey, now: datetime, clock: ZoneInfo) -> str:
    """One line of a ride's life, for people."""
    wish = journey.wish
    words = {
        "requested": f"asks: {wish.from_stop} to {wish.to_stop}, party of {wish.party}",
        "assigned": f"gets {journey.vehicle_id}{_promise(journey, clock)}",
        "boarding": f"{journey.vehicle_id} is at the stop",
        "aboard": f"is aboard {journey.vehicle_id} ({wish.how})",
        "completed": "has arrived",
    }
    text = words.get(journey.state, f"{journey.state}: {journey.reason}")
    return f"{now.astimezone(clock):%H:%M:%S}  ride {wish.number} {text}"


def _promise(journey: Journey, clock: ZoneInfo) -> str:
    if journey.promise is None:
        return ""
    pickup_from, pickup_to, arrive_by = (
        datetime.fromisoformat(journey.promise[name]).astimezone(clock)
        for name in ("pickup_from", "pickup_to", "arrive_by")
    )
    return f", pickup {pickup_from:%H:%M}-{pickup_to:%H:%M}, there by {arrive_by:%H:%M}"


def print_summary(
    console: Console, campus: "VirtualCampus", journeys: list[Journey], scores: RideScores
) -> None:
    rides = Table(title="Rides", title_justify="left")
    for heading in (
        "ride",
        "from",
        "to",
        "party",
        "how",
        "state",
        "waited s",
        "rode s",
        "rode m",
        "encounters",
        "promise",
    ):
        is_figure = heading in ("waited s", "rode s", "rode m", "encounters")
        rides.add_column(heading, justify="right" if is_figure else "left", no_wrap=not is_figure)
    for journey in journeys:
        wish = journey.wish
        kept = "" if journey.promise is None else ("broken" if journey.promise_broken else "kept")
        rides.add_row(
            str(wish.number),
            wish.from_stop,
            wish.to_stop,
            str(wish.party),
            wish.how,
            journey.state,
            _seconds(journey.wait_s),
            _seconds(journey.ride_s),
            _seconds(scores.distance_m(journey)),
            str(scores.encounters(journey)),
            kept,
        )
    console.print(rides)
    print_vehicles(console, campus)


def print_vehicles(console: Console, campus: "VirtualCampus") -> None:
    """What each vehicle did, by ground truth."""
    table = Table(title="Vehicles", title_justify="left")
    for heading in (
        "vehicle",
        "distance m",
        "contacts",
        "encounters",
        "stood for people s",
        "hardest braking m/s2",
        "least clearance m",
        "planning p99 ms",
        "tick p50 / p99 ms",
    ):
        table.add_column(heading, justify="left" if heading == "vehicle" else "right")
    for vehicle_id, vehicle in campus.vehicles.items():
        score = campus.world.score(vehicle_id)
        ticks_ms = np.array(vehicle.times.whole) / 1e6
        planning_ms = np.array(vehicle.times.by_room["planning"]) / 1e6
        table.add_row(
            vehicle_id,
            f"{score.distance_m:.0f}",
            str(score.contacts),
            str(score.encounters),
            f"{score.stopped_for_people_s:.0f}",
            f"{score.hardest_braking_mps2:.2f}",
            f"{score.clearance_m_min:.2f}",
            f"{np.percentile(planning_ms, 99):.2f}",
            f"{np.percentile(ticks_ms, 50):.2f} / {np.percentile(ticks_ms, 99):.2f}",
        )
    console.print(table)


def _seconds(value: float | None) -> str:
    return "" if value is None else f"{value:.0f}"
