"""`campusloop simulate --km`: rides and timetables on campuses in virtual time until a distance is driven.

The drive is divided into shifts. Each is a campus of its own with its own seed: server, shuttles, riders and
people. Shifts run in parallel on the available cores, and a seed repeats all of them.
"""

import logging
import tempfile
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from itertools import count
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
import structlog

from campusloop.campaigns.campaign import Campaign
from campusloop.clients.passengers import Journey
from campusloop.clients.ride_demand import RIDE_M_MIN, random_rides, stop_pairs
from campusloop.scenes.stacks import perceiving, profile_of
from campusloop.virtual.campus import CampusOptions, VirtualCampus
from contract.geometry import Array
from contract.roads.load import load_map
from contract.wire.messages import Blocked, ModeChanged
from simulator.scoring.ride_quality import Stretch, stretch
from simulator.sensors.scene_lidars import scene_of_run

SHIFT_S = 3600.0
_VEHICLES = 2
_RIDES_EVERY_S = 150.0
_RIDE_M_MAX = 2000.0
_RESUME_AFTER_S = 15.0
_ERROR_TICKS = 50
# With a timetable, shifts begin with its periods; otherwise with the working day.
_WORK_BEGINS_S = 8 * 3600


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What the shuttles see of a campus, and what they localize by.

    scene       hills, kerbs, trees and parked vehicles of the shift's seed; otherwise walls on a plane
    campus_sky  buildings hide satellites and reflect their signals
    point_map   the folder of the map that they compare their scans with; None: GNSS/INS alone
    own_perception  they find road users in their lidars' scans; otherwise a tracker of the truth gives them
    """

    scene: bool = False
    campus_sky: bool = False
    point_map: Path | None = None
    own_perception: bool = False


@dataclass(frozen=True, slots=True)
class EnduranceShift:
    map_path: Path
    stack: str
    seed: int
    number: int
    duration_s: float = SHIFT_S
    plant_seed: int | None = None
    surroundings: Surroundings = Surroundings()


@dataclass(slots=True)
class ShiftFigures:
    """The figures of all shuttles in one shift.

    takeovers          why an operator would have had to take over
    position_errors_m  of shuttles that say that they know where they are, once a second
    """

    shift: EnduranceShift
    distance_m: float = 0.0
    stretches: list[Stretch] = field(default_factory=list)
    plan_ms: list[float] = field(default_factory=list)
    contacts: int = 0
    takeovers: list[str] = field(default_factory=list)
    rides_completed: int = 0
    position_errors_m: list[float] = field(default_factory=list)


def run_shift(shift: EnduranceShift) -> ShiftFigures:
    """Run one campus for the shift's duration; its run logs are deleted."""
    road_map, around = load_map(shift.map_path), shift.surroundings
    profile = perceiving(profile_of(shift.stack), around.own_perception)
    zone = ZoneInfo(road_map.timezone)
    starts = sorted({trip.calls[0][1] // 7200 * 7200 for trip in road_map.timetable}) or [_WORK_BEGINS_S]
    midnight = datetime(2026, 9, 1, tzinfo=zone) + timedelta(days=shift.number // len(starts))
    begins = midnight + timedelta(seconds=starts[shift.number % len(starts)])
    with tempfile.TemporaryDirectory(prefix="campusloop-km-") as folder:
        options = CampusOptions(
            road_map,
            Path(folder),
            seed=shift.seed,
            vehicles=_VEHICLES,
            profile=profile,
            begins=begins.astimezone(UTC),
            plant_seed=shift.plant_seed,
            scene=scene_of_run(shift.seed) if around.scene else None,
            campus_sky=around.campus_sky,
            point_map=around.point_map,
        )
        campus = VirtualCampus(options)
        campus.start()
        monitor = _Monitor(campus)
        pairs = stop_pairs(road_map, RIDE_M_MIN, _RIDE_M_MAX)
        demands = random_rides(
            max(1, round(shift.duration_s / _RIDES_EVERY_S)),
            pairs,
            _RIDES_EVERY_S,
            campus.conductor.rng("rides"),
        )
        passengers = campus.passengers(lambda _journey: None)
        journeys = [Journey(demand) for demand in demands]
        for journey in journeys:
            campus.conductor.loop.create_task(passengers.run_journey(journey))
        for _ in range(round(shift.duration_s * 50)):
            campus.conductor.step()
            monitor.sample()
        figures = monitor.figures(shift)
        figures.rides_completed = sum(journey.state == "completed" for journey in journeys)
        campus.stop()
    return figures


class _Monitor:
    """Samples every shuttle after each step, and resumes stopped shuttles as an operator would."""

    def __init__(self, campus: VirtualCampus) -> None:
        self._campus = campus
        self._speeds: dict[str, list[float]] = {name: [] for name in campus.vehicles}
        self._stretches: list[Array] = []
        self._stopped_ns: dict[str, int] = {}
        self._odometer_m = {name: campus.world.truth(name).odometer_m for name in campus.vehicles}

    def sample(self) -> None:
        campus = self._campus
        for name, vehicle in campus.vehicles.items():
            outputs = vehicle.outputs
            if outputs is None:
                continue
            flow = outputs.flow
            if flow.task.mode == "drive" and flow.guard_status.mode != "manual":
                self._speeds[name].append(abs(campus.world.truth(name).speed_mps))
            else:
                self._cut(name)
            if flow.guard_status.mode in ("minimal_risk", "fault", "manual"):
                self._resume_stopped(name)
            else:
                self._stopped_ns.pop(name, None)

    def figures(self, shift: EnduranceShift) -> ShiftFigures:
        out = ShiftFigures(shift)
        for name, vehicle in self._campus.vehicles.items():
            self._cut(name)
            out.distance_m += self._campus.world.truth(name).odometer_m - self._odometer_m[name]
            out.plan_ms += vehicle.wired.plan_cpu_ms
            # All ticks of a thousand kilometres would fill the memory.
            out.position_errors_m += vehicle.position_errors_m[::_ERROR_TICKS]
            out.contacts += self._campus.world.score(name).contacts
            for now_ns, event in vehicle.happened:
                at = f"{shift.map_path.parent.name} shift {shift.number} {name} {now_ns / 1e9:.0f} s"
                if isinstance(event, ModeChanged) and event.mode in ("minimal_risk", "fault"):
                    out.takeovers.append(f"{at}: {event.mode}")
                elif isinstance(event, Blocked) and not event.cleared:
                    out.takeovers.append(f"{at}: blocked for 60 s")
        out.takeovers += ["contact"] * out.contacts
        out.stretches = [one for speeds in self._stretches if (one := stretch(speeds)) is not None]
        return out

    def _cut(self, name: str) -> None:
        """End the present stretch of driving."""
        if self._speeds[name]:
            self._stretches.append(np.array(self._speeds[name]))
            self._speeds[name] = []

    def _resume_stopped(self, name: str) -> None:
        campus, now_ns = self._campus, self._campus.conductor.now_ns
        since_ns = self._stopped_ns.setdefault(name, now_ns)
        if now_ns - since_ns >= _RESUME_AFTER_S * 1e9:
            self._stopped_ns[name] = now_ns
            campus.conductor.loop.create_task(campus.operator.command(name, "resume"))


def drive_km(
    campaign: Campaign,
    maps: tuple[Path, ...],
    stack: str,
    km: float,
    seed: int,
    shift_s: float,
    report: Callable[[ShiftFigures, float], None],
    plant_seed: int | None = None,
    surroundings: Mapping[Path, Surroundings] | None = None,
) -> list[ShiftFigures]:
    """Run shifts on the maps in turn until km are driven; report: called after each, with the km so far.

    plant_seed: of the first shift's dynamics, the next shift has the next one; None: nominal ones
    surroundings: by the map's path; walls on a plane, and GNSS, where they do not have it

    The shifts do not depend on the number of workers: one that was begun needlessly is left out.

    Raises CampaignError.
    """
    shifts = (
        EnduranceShift(
            maps[begun % len(maps)],
            stack,
            seed + begun,
            begun // len(maps),
            shift_s,
            None if plant_seed is None else plant_seed + begun,
            (surroundings or {}).get(maps[begun % len(maps)], Surroundings()),
        )
        for begun in count()
    )
    done: list[ShiftFigures] = []
    so_far_m = 0.0
    with closing(campaign.run(run_shift, shifts, ahead=campaign.size)) as results:
        while so_far_m < 1000.0 * km:
            done.append(next(results))
            so_far_m += done[-1].distance_m
            report(done[-1], so_far_m / 1000.0)
    return done


def log_errors_only() -> None:
    """Without this, a campus logs every link."""
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.ERROR))
