"""One random drive through a crowd, as a job of a campaign."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row
from benchmarks.reporting.run_logs import LogChoice
from campusloop.scenes.drive import SceneDrive
from campusloop.scenes.people_met import people_met
from campusloop.scenes.random_crowds import RandomScene, SceneSources, draw_scene, scene_sources
from campusloop.scenes.stacks import perceiving, profile_of
from campusloop.scenes.stalls import stalls

_MAPS = Path(__file__).resolve().parents[2] / "maps"


@dataclass(frozen=True, slots=True)
class MonteCarloDrive:
    """recordings: folder of recorded people; traces: folder for two CSV files; None for none.

    plant_seed: of the vehicle's dynamics; None: nominal ones
    """

    stack: str
    seed: int
    recordings: Path | None
    traces: Path | None
    logs: LogChoice
    plant_seed: int | None = None
    own_perception: bool = False


@lru_cache(maxsize=1)
def sources(recordings: Path | None) -> SceneSources:
    """Shipped paths, and recorded people. Raises RecordingError."""
    return scene_sources(tuple(sorted(_MAPS.glob("*/map.json"))), recordings)


def drive(job: MonteCarloDrive) -> Row:
    """One drive; in a sparse and in a dense crowd also the same drive without people."""
    drawn = draw_scene(
        sources(job.recordings), perceiving(profile_of(job.stack), job.own_perception), job.seed
    )
    scene = drawn.scene.with_plant(job.plant_seed)
    run = SceneDrive(scene, job.logs.of(drawn.scene.name)).run()
    if job.traces is not None:
        run.trace.write(job.traces / job.stack, drawn.scene.name)
    rows, metrics = run.trace.array(), run.metrics
    mean_mps = run.driven_m / max(float(rows[-1, 0]), 1e-9)
    free_mps = _free_mps(drawn, job.plant_seed) if drawn.is_sparse or drawn.is_dense else None
    cpu_ms = run.plan_cpu_ms or (0.0,)
    return {
        "stack": job.stack,
        "seed": job.seed,
        "path": drawn.path,
        "crowd": drawn.crowd,
        "people_per_100m2": drawn.people_per_100m2,
        "people_met_per_100m2": people_met(rows, run.trace.agents, scene.profile.body).per_100m2,
        "time_s": float(rows[-1, 0]),
        "driven_m": run.driven_m,
        "reached": run.time_s is not None,
        "contacts": len(metrics.front_contacts),
        "other_contacts": len(metrics.other_contacts),
        "people_removed": drawn.removed,
        "clearance_m": metrics.clearance_m if np.isfinite(metrics.clearance_m) else None,
        "mean_mps": mean_mps,
        "free_mps": free_mps,
        "stalls": stalls(run, drawn.scene),
        "plan_cpu_p95_ms": float(np.percentile(cpu_ms, 95)),
        "limited_by": " ".join(f"{name}:{count}" for name, count in run.limited_by[:3]),
    }


def _free_mps(drawn: RandomScene, plant_seed: int | None) -> float:
    run = SceneDrive(drawn.without_people().with_plant(plant_seed)).run()
    return run.driven_m / max(float(run.trace.array()[-1, 0]), 1e-9)
