"""Drives of protection cells and of quiet streets, as jobs of a campaign."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row
from benchmarks.reporting.run_logs import LogChoice
from campusloop.scenes.drive import SceneDrive
from campusloop.scenes.protection.braking_oracle import best_braking
from campusloop.scenes.protection.cell import Cell
from campusloop.scenes.protection.quiet_street import quiet_street
from vehicle_agent.config import Profile

HARD_MPS2 = -3.0
STREET_M = 500.0


@dataclass(frozen=True, slots=True)
class CellDrive:
    """seed: of sensor noise; plant_seed: of the vehicle's dynamics, None for nominal ones."""

    cell: Cell
    profile: Profile
    seed: int
    plant_seed: int | None
    traces: Path | None
    logs: LogChoice


@dataclass(frozen=True, slots=True)
class StreetDrive:
    """seed: of street, people and sensor noise."""

    profile: Profile
    seed: int
    plant_seed: int | None


@dataclass(frozen=True, slots=True)
class StreetResult:
    """hard_stops: needless, since nobody is ever in the way."""

    hard_stops: int
    driven_m: float
    time_s: float


def drive_cell(job: CellDrive) -> Row:
    """The row of one cell, beside that of the oracle."""
    cell, profile = job.cell, job.profile
    best = best_braking(cell, profile.body, profile.lidar.x_m)
    run = SceneDrive(cell.scene(profile, job.seed).with_plant(job.plant_seed), job.logs.of(cell.name)).run()
    if job.traces is not None:
        run.trace.write(job.traces, cell.name)
    hits = [speed_mps for _, number, speed_mps in run.metrics.front_contacts if number == 1]
    return {
        "cell": cell.name,
        "kind": cell.kind,
        "light": cell.light,
        "speed_kmh": cell.speed_mps * 3.6,
        "plant_seed": job.plant_seed,
        "avoidable": best.impact_mps is None,
        "avoided": not hits,
        "impact_mps": hits[0] if hits else None,
        "least_impact_mps": best.impact_mps,
        "clearance_m": run.metrics.clearance_m if np.isfinite(run.metrics.clearance_m) else None,
        "passed": run.time_s is not None,
    }


def drive_street(job: StreetDrive) -> StreetResult:
    """One street of STREET_M."""
    scene = quiet_street(job.profile, STREET_M, job.seed).with_plant(job.plant_seed)
    run = SceneDrive(scene).run()
    rows = run.trace.array()
    hard = rows[:, 5] < HARD_MPS2
    return StreetResult(int((hard[1:] & ~hard[:-1]).sum()), run.driven_m, float(rows[-1, 0]))
