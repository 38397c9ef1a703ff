"""`campusloop demo --headless --from 07:55 --to 10:05`: a stretch of the map's timetable in virtual time.

Every call is compared with the vehicles' events: the moment at which a shuttle closed its doors and left the
stop.
"""

import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

from rich.console import Console
from rich.table import Table

from campusloop.virtual.campus import START_NS, CampusOptions, VirtualCampus
from campusloop.virtual.headless import contacts, print_vehicles
from campusloop.virtual.run_proof import IntervalPrinter, RunProof, flaws, virtual_progress
from contract.roads.model import RoadMap
from contract.wire.messages import VisitChanged

WARM_UP = timedelta(minutes=20)
LATE_MAX_S = 60.0
EARLY_MAX_S = 0.0


@dataclass(frozen=True, slots=True)
class TimetableCallResult:
    """One call of a trip. left_at: when a shuttle left it, or arrived at the trip's last stop; or None."""

    trip_id: str
    stop_id: str
    planned: datetime
    left_at: datetime | None
    is_last: bool

    @property
    def late_s(self) -> float | None:
        return None if self.left_at is None else (self.left_at - self.planned).total_seconds()

    @property
    def is_on_time(self) -> bool:
        """Not early and at most a minute late; at a trip's last stop it may be early."""
        if self.late_s is None or self.late_s > LATE_MAX_S:
            return False
        return self.is_last or self.late_s >= EARLY_MAX_S


@dataclass(frozen=True, slots=True)
class Stay:
    stop_id: str
    arrived: datetime
    left: datetime


def run_timetable(
    options: CampusOptions, begins: datetime, ends: datetime, console: Console
) -> tuple[list[TimetableCallResult], list[str]]:
    """Drive the timetable between two moments. Returns the calls, and all failures as texts."""
    started = time.perf_counter()
    options = replace(options, begins=(begins - WARM_UP).astimezone(UTC))
    zone = ZoneInfo(options.road_map.timezone)
    campus = VirtualCampus(options)
    campus.start()
    with RunProof(options.folder) as proof:
        with virtual_progress(console) as progress:
            bar = progress.add_task("virtual s", total=round((ends - campus.now()).total_seconds()), clock="")
            printer = IntervalPrinter(console)
            while campus.now() < ends:
                campus.conductor.run_for(5.0)
                proof.replay_closed()
                clock = f"{campus.now().astimezone(zone):%H:%M:%S}"
                progress.update(bar, advance=5, clock=clock)
                printer.print(f"{clock}  {proof.replayed} segments are replayed")
        virtual_s = (campus.conductor.now_ns - START_NS) / 1e9
        calls = _calls(campus, options.road_map, begins, ends)
        campus.stop()
        proofs = proof.results(console)
    failures = [
        f"{call.trip_id} at {call.stop_id}: "
        + ("no shuttle came" if call.late_s is None else f"{call.late_s:+.0f} s")
        for call in calls
        if not call.is_on_time
    ]
    failures += contacts(campus)
    failures += flaws(proofs)
    _print(console, calls, zone)
    print_vehicles(console, campus)
    wall_s = time.perf_counter() - started
    console.print(f"{virtual_s:.0f} virtual s in {wall_s:.0f} s wall, {len(proofs)} segments replayed")
    return calls, failures


def local_moment(day: datetime, clock_time: str, zone: ZoneInfo) -> datetime:
    """HH:MM on the day of `day`, in the campus's time zone. Raises ValueError for another format."""
    moment = datetime.strptime(clock_time, "%H:%M").replace(tzinfo=zone)
    return moment.replace(year=day.year, month=day.month, day=day.day)


def _calls(
    campus: VirtualCampus, road_map: RoadMap, begins: datetime, ends: datetime
) -> list[TimetableCallResult]:
    """Each planned call with the stay that served it: the first that ends at the planned time or later."""
    stays = _stays(campus)
    midnight = begins.astimezone(ZoneInfo(road_map.timezone)).replace(
        hour=0, minute=0, second=0, microsecond=0
    )
    results = []
    for trip in road_map.timetable:
        for number, (stop_id, second) in enumerate(trip.calls):
            planned = midnight + timedelta(seconds=second)
            if not begins <= planned <= ends:
                continue
            is_last = number == len(trip.calls) - 1
            serving = [stay for stay in stays if stay.stop_id == stop_id and stay.left >= planned]
            at = None
            if serving:
                stay = min(serving, key=lambda stay: stay.left)
                at = stay.arrived if is_last else stay.left
            results.append(TimetableCallResult(trip.trip_id, stop_id, planned, at, is_last))
    return results


def _stays(campus: VirtualCampus) -> list[Stay]:
    """Every stay at a stop; one that still lasts ends now."""
    stays: list[Stay] = []
    for vehicle in campus.vehicles.values():
        arrived: dict[str, Stay] = {}
        for now_ns, event in vehicle.happened:
            if not isinstance(event, VisitChanged) or not event.stop_id:
                continue
            at = campus.options.begins + timedelta(microseconds=now_ns // 1000)
            if event.state == "under_way":
                arrived[event.visit_id] = Stay(event.stop_id, at, campus.now())
            elif event.state == "done" and event.visit_id in arrived:
                arrived[event.visit_id] = replace(arrived[event.visit_id], left=at)
        stays += arrived.values()
    return stays


def _print(console: Console, calls: list[TimetableCallResult], zone: ZoneInfo) -> None:
    table = Table(title="Timetable", title_justify="left")
    for heading in ("trip", "stop", "planned", "left / arrived", "late s", "kept"):
        table.add_column(heading, justify="right" if heading == "late s" else "left")
    for call in calls:
        table.add_row(
            call.trip_id,
            call.stop_id,
            f"{call.planned.astimezone(zone):%H:%M:%S}",
            "" if call.left_at is None else f"{call.left_at.astimezone(zone):%H:%M:%S}",
            "" if call.late_s is None else f"{call.late_s:.0f}",
            "yes" if call.is_on_time else "NO",
        )
    console.print(table)
