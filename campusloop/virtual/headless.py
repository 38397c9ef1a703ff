"""`campusloop demo --headless`: rides in virtual time, as fast as the machine allows.

Simulated passengers book the rides, the real onboard loop drives them among people, and every run is replayed
at the end. The summary comes from ground truth and from run logs.
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
from campusloop.clients.ride_texts import promise_text
from campusloop.virtual.run_proof import IntervalPrinter, RunProof, flaws, virtual_progress

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
    """The vehicle's score at the beginning and at the end of each ride."""

    def __init__(self, campus: "VirtualCampus") -> None:
        self._campus = campus
        self._begun: dict[int, tuple[float, int]] = {}
        self._ended: dict[int, tuple[float, int]] = {}

    def note(self, journey: Journey) -> None:
        if journey.state in ("aboard", "completed"):
            score = self._campus.world.score(journey.vehicle_id)
            at = self._begun if journey.state == "aboard" else self._ended
            at[journey.demand.number] = (score.distance_m, score.encounters)

    def distance_m(self, journey: Journey) -> float | None:
        number = journey.demand.number
        return self._ended[number][0] - self._begun[number][0] if number in self._ended else None

    def encounters(self, journey: Journey) -> int:
        number = journey.demand.number
        return self._ended[number][1] - self._begun[number][1] if number in self._ended else 0


def run_headless(
    options: "CampusOptions",
    rides: int,
    console: Console,
    pairs: list[tuple[str, str]] | None = None,
    spacing_s: float = SPACING_S,
) -> DemoResult:
    """Run the campus until every ride has ended, replay every run, print the summary.

    pairs: the stops of rides to choose from; by default all pairs between RIDE_M_MIN and RIDE_M_MAX apart
    spacing_s: mean time between two passengers' requests
    """
    # This imports the whole server, which the live demo's own process does not need.
    from campusloop.virtual.campus import START_NS, VirtualCampus

    started = time.perf_counter()
    console.print(
        f"building the campus: {options.road_map.name}, {options.vehicles} shuttles", highlight=False
    )
    campus = VirtualCampus(options)
    clock = ZoneInfo(options.road_map.timezone)

    scores = RideScores(campus)

    def on_change(journey: Journey) -> None:
        scores.note(journey)
        console.print(timeline_line(journey, campus.now(), clock), highlight=False, soft_wrap=True)

    campus.start()
    pairs = pairs or stop_pairs(options.road_map, RIDE_M_MIN, RIDE_M_MAX)
    demands = random_rides(rides, pairs, spacing_s, campus.conductor.rng("passengers"))
    passengers = campus.passengers(on_change)
    tasks = [campus.conductor.loop.create_task(passengers.run_journey(Journey(demand))) for demand in demands]
    with RunProof(options.folder) as proof:
        with virtual_progress(console) as progress:
            bar = progress.add_task("rides", total=rides, clock="")
            deadline_ns = campus.conductor.now_ns + round(RIDE_TIMEOUT_S * 1e9)
            printer = IntervalPrinter(console)
            while not all(task.done() for task in tasks) and campus.conductor.now_ns < deadline_ns:
                for _ in range(STEPS_PER_REFRESH):
                    campus.conductor.step()
                proof.replay_closed()
                done = sum(task.done() for task in tasks)
                speedup = (campus.conductor.now_ns - START_NS) / 1e9 / (time.perf_counter() - started)
                moment = f"{campus.now().astimezone(clock):%H:%M:%S}, {speedup:.1f} x"
                progress.update(bar, completed=done, clock=f"{moment}, {driving(campus)}")
                printer.print(f"{moment}  {done} of {rides} rides have ended; {driving(campus)}")
        virtual_s = (campus.conductor.now_ns - START_NS) / 1e9
        campus.stop()
        wall_s = time.perf_counter() - started
        proofs = proof.results(console)
    journeys = [task.result() for task in tasks if task.done()]
    failures = [
        f"ride {demand.number} did not end"
        for demand, task in zip(demands, tasks, strict=True)
        if not task.done()
    ]
    failures += [
        f"ride {j.demand.number} ended as {j.state} ({j.reason})" for j in journeys if j.state != "completed"
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
    """The vehicles that had contacts, by ground truth."""
    scores = {vehicle_id: campus.world.score(vehicle_id) for vehicle_id in campus.vehicles}
    return [f"{name} had {score.contacts} contacts" for name, score in scores.items() if score.contacts]


def driving(campus: "VirtualCampus") -> str:
    """How far each shuttle has driven, by ground truth."""
    return ", ".join(f"{name} {campus.world.score(name).distance_m:.0f} m" for name in campus.vehicles)


def timeline_line(journey: Journey, now: datetime, clock: ZoneInfo) -> str:
    """A line of text about a ride's new state."""
    demand = journey.demand
    texts = {
        "requested": f"requested: {demand.from_stop} to {demand.to_stop}, party of {demand.party}",
        "assigned": f"gets {journey.vehicle_id}{promise_text(journey.promise, clock)}",
        "boarding": f"{journey.vehicle_id} is at the stop",
        "aboard": f"is aboard {journey.vehicle_id} ({demand.how})",
        "completed": "has arrived",
    }
    text = texts.get(journey.state, f"{journey.state}: {journey.reason}")
    return f"{now.astimezone(clock):%H:%M:%S}  ride {demand.number} {text}"


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
        demand = journey.demand
        kept = "" if journey.promise is None else ("broken" if journey.promise_broken else "kept")
        rides.add_row(
            str(demand.number),
            demand.from_stop,
            demand.to_stop,
            str(demand.party),
            demand.how,
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
    """Print a table of the vehicles' figures, by ground truth."""
    table = Table(title="Vehicles", title_justify="left")
    for heading in (
        "vehicle",
        "distance m",
        "contacts",
        "encounters",
        "stood for people s",
        "hardest braking m/s2",
        "least clearance m",
        "position error rms / p99 m",
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
            position_text(vehicle.position_errors_m),
            f"{np.percentile(planning_ms, 99):.2f}",
            f"{np.percentile(ticks_ms, 50):.2f} / {np.percentile(ticks_ms, 99):.2f}",
        )
    console.print(table)


def position_text(errors_m: list[float]) -> str:
    """Root mean square and 99th percentile; "" for a vehicle that never knew where it is."""
    if not errors_m:
        return ""
    errors = np.array(errors_m)
    return f"{np.sqrt(np.mean(errors**2)):.3f} / {np.percentile(errors, 99):.3f}"


def _seconds(value: float | None) -> str:
    return "" if value is None else f"{value:.0f}"
