"""Scores of the drivers, each alone and against ours in the scenes that both drove."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.reporting.report import Row, Value
from campusloop.scenes.drive import Scene, SceneRun

OURS = "snow_lion"
# Ends the names of drivers under exact conditions.
EXACT = "_exact"


@dataclass(frozen=True, slots=True)
class Result:
    """One drive.

    cycles_cpu_ms  of each planning cycle, empty for a driver without one
    unfinished     ended because its planning took too long: only its cycles count
    """

    driver: str
    scene: str
    kind: str
    time_s: float
    reached: bool
    contacts: int
    other_contacts: int
    clearance_m: float
    driven_m: float
    speed_cap_mps: float
    cycles_cpu_ms: tuple[float, ...]
    words: tuple[tuple[str, int], ...] = ()
    unfinished: bool = False

    @property
    def success(self) -> bool:
        """The goal was reached within the scene's time, without a front contact."""
        return self.reached and self.contacts == 0 and not self.unfinished

    def row(self) -> Row:
        return {
            "driver": self.driver,
            "scene": self.scene,
            "kind": self.kind,
            "success": self.success,
            "reached": self.reached,
            "unfinished": self.unfinished,
            "time_s": self.time_s,
            "contacts": self.contacts,
            "other_contacts": self.other_contacts,
            "clearance_m": self.clearance_m if math.isfinite(self.clearance_m) else None,
            "driven_m": self.driven_m,
            "speed_ratio": speed_ratio(self),
            "cycle_p50_cpu_ms": _percentile(self.cycles_cpu_ms, 50),
            "cycle_p95_cpu_ms": _percentile(self.cycles_cpu_ms, 95),
            "words": " ".join(f"{word[:60]}:{count}" for word, count in self.words[:3]),
        }


def result_of(
    driver: str, kind: str, scene: Scene, run: SceneRun, cap_mps: float, *, unfinished: bool = False
) -> Result:
    """A drive that did not reach its goal counts with the time at which it was ended."""
    return Result(
        driver,
        scene.name,
        kind,
        run.time_s if run.time_s is not None else scene.limit_s,
        run.time_s is not None,
        len(run.metrics.front_contacts),
        len(run.metrics.other_contacts),
        run.metrics.clearance_m,
        run.driven_m,
        cap_mps,
        run.plan_cpu_ms,
        run.limited_by,
        unfinished,
    )


def speed_ratio(result: Result) -> float:
    """Mean speed over the scene's cap."""
    return result.driven_m / max(result.time_s, 1e-9) / max(result.speed_cap_mps, 1e-9)


def summary(results: Sequence[Result]) -> Row:
    """Figures of each driver, then of each against ours on its terms (`versus.`), over the scenes of both.

    versus.X.time_ratio    X's time over ours, where both succeeded: above 1, ours is faster
    versus.X.cycle_ratio   X's median cycle over ours, CPU, of all cycles: above 1, ours is faster
    """
    drivers = list(dict.fromkeys(result.driver for result in results))
    by_driver = {driver: [r for r in results if r.driver == driver] for driver in drivers}
    out: dict[str, Value] = {}
    for driver, mine in by_driver.items():
        out |= {f"{driver}.{key}": value for key, value in figures(mine).items()}
    for driver in drivers:
        ours = f"{OURS}{EXACT}" if driver.endswith(EXACT) else OURS
        if driver != ours and ours in by_driver:
            found = versus(by_driver[ours], by_driver[driver])
            out |= {f"versus.{driver}.{key}": value for key, value in found.items()}
    return out


def figures(mine: Sequence[Result]) -> dict[str, Value]:
    """Of one driver over the scenes that it finished; the cycles of all."""
    cycles = [cycle for r in mine for cycle in r.cycles_cpu_ms]
    unfinished, mine = sum(r.unfinished for r in mine), [r for r in mine if not r.unfinished]
    clear = [r.clearance_m for r in mine if math.isfinite(r.clearance_m)]
    return {
        "scenes": len(mine),
        "unfinished": unfinished,
        "success_pct": 100.0 * sum(r.success for r in mine) / len(mine) if mine else None,
        "reached_pct": 100.0 * sum(r.reached for r in mine) / len(mine) if mine else None,
        "scenes_with_contact": sum(r.contacts > 0 for r in mine),
        "contacts": sum(r.contacts for r in mine),
        "other_contacts": sum(r.other_contacts for r in mine),
        "mean_speed_ratio": float(np.mean([speed_ratio(r) for r in mine])) if mine else None,
        "time_s": sum(r.time_s for r in mine),
        "clearance_median_m": float(np.median(clear)) if clear else None,
        "cycle_p50_cpu_ms": _percentile(cycles, 50),
        "cycle_p95_cpu_ms": _percentile(cycles, 95),
    }


def versus(ours: Sequence[Result], theirs: Sequence[Result]) -> dict[str, Value]:
    """In the scenes that both drove, by name."""
    mine = {r.scene: r for r in ours}
    pairs = [(mine[r.scene], r) for r in theirs if r.scene in mine]
    our_cycles = [cycle for a, _ in pairs for cycle in a.cycles_cpu_ms]
    their_cycles = [cycle for _, b in pairs for cycle in b.cycles_cpu_ms]
    pairs = [(a, b) for a, b in pairs if not b.unfinished]
    both = [(a, b) for a, b in pairs if a.success and b.success]
    ratio = None
    if our_cycles and their_cycles:
        ratio = float(np.median(their_cycles) / np.median(our_cycles))
    return {
        "scenes": len(pairs),
        "success_pct_ours": 100.0 * sum(a.success for a, _ in pairs) / len(pairs) if pairs else None,
        "success_pct_theirs": 100.0 * sum(b.success for _, b in pairs) / len(pairs) if pairs else None,
        "contacts_ours": sum(a.contacts for a, _ in pairs),
        "contacts_theirs": sum(b.contacts for _, b in pairs),
        "both_succeeded": len(both),
        "time_ratio": sum(b.time_s for _, b in both) / sum(a.time_s for a, _ in both) if both else None,
        "time_ratio_all": sum(b.time_s for _, b in pairs) / sum(a.time_s for a, _ in pairs)
        if pairs
        else None,
        "cycle_ratio": ratio,
    }


def _percentile(values: Sequence[float], share: float) -> float | None:
    return float(np.percentile(values, share)) if values else None
