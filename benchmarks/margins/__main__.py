"""What each allowance for people costs in time: `python -m benchmarks.margins DIR [--people aware]`.

Drives the recordings in DIR as `benchmarks.crowd` does, with the Snow Lion stack as it is, and again without
one allowance at a time (`allowances.py`). A cost is the time of all drives with the allowance less the time
without it, as a share of the humans' time. It is what the time would fall by; contacts show what the
allowance is for. Drives among people are chaotic: a single person met or not can decide about half a minute,
so a cost below a few hundredths is none. The recordings that parameters were tuned on (the split of
`benchmarks.people`) and the others are reported apart.
"""

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.margins.allowances import ALLOWANCES, Allowance
from benchmarks.people.samples import fitted_recordings
from benchmarks.reporting.report import Row, RunReport
from campusloop.scenes.crowd_clips import PEOPLE, People, clip_runs
from campusloop.scenes.drive import SceneDrive
from campusloop.scenes.stacks import profile_of
from simulator.traffic.recordings import Clip, RecordingError, drone_clips
from vehicle_agent.config import Profile
from vehicle_agent.planning.worker import MotionPlanner
from vehicle_agent.stacks.snow_lion import behaviour_rules, motion_params

_AS_IT_IS = Allowance("none", "the stack as it is")


@dataclass(frozen=True, slots=True)
class DriveTime:
    """One drive; is_fitted: parameters were tuned on its recording among others."""

    is_fitted: bool
    human_s: float
    time_s: float
    reached: bool
    contacts: int
    clearance_m: float


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    try:
        clips = drone_clips(arguments.folder)
    except RecordingError as error:
        raise SystemExit(f"cannot drive: {error}") from error
    chosen = set(arguments.only.split(",")) if arguments.only else {item.name for item in ALLOWANCES}
    unknown = chosen - {item.name for item in ALLOWANCES}
    if unknown:
        raise SystemExit(f"no such allowance: {', '.join(sorted(unknown))}")
    profile = profile_of("snow_lion")
    rows: list[Row] = []
    whole: list[DriveTime] = []
    for allowance in (_AS_IT_IS, *(item for item in ALLOWANCES if item.name in chosen)):
        drives = driven(clips, profile, arguments.people, arguments.seed, allowance)
        whole = whole or drives
        rows.append(_row(allowance, drives, whole))
        print(rows[-1], flush=True)
    report.write(
        arguments.json,
        "margins",
        {"folder": str(arguments.folder), "people": arguments.people, "seed": arguments.seed},
        rows,
        {f"{row['allowance']}.cost": row["cost"] for row in rows[1:]},
    )


def driven(
    clips: Sequence[Clip], profile: Profile, people: People, seed: int, without: Allowance
) -> list[DriveTime]:
    """All drives of the clips without an allowance."""
    fitted = fitted_recordings()
    found = []
    for clip in clips:
        for clip_run in clip_runs(clip, profile, seed, people):
            scene = clip_run.scene
            if without.tracker is not None:
                scene = replace(scene, options=replace(scene.options, tracker=without.tracker))
            planner = MotionPlanner(
                without.rules(behaviour_rules(scene.profile)), without.motion(motion_params(scene.profile))
            )
            run = SceneDrive(scene, planner=planner, adapt=without.car).run()
            found.append(
                DriveTime(
                    clip.name in fitted,
                    clip_run.human_time_s,
                    run.time_s if run.time_s is not None else scene.limit_s,
                    run.time_s is not None,
                    len(run.metrics.front_contacts),
                    run.metrics.clearance_m,
                )
            )
    return found


def _row(allowance: Allowance, drives: Sequence[DriveTime], whole: Sequence[DriveTime]) -> Row:
    pairs = list(zip(whole, drives, strict=True))
    return {
        "allowance": allowance.name,
        "without": allowance.what,
        "time_ratio": _ratio(drives),
        "cost": _cost(pairs),
        "cost_fit": _cost([pair for pair in pairs if pair[0].is_fitted]),
        "cost_held_out": _cost([pair for pair in pairs if not pair[0].is_fitted]),
        "failures": sum(not drive.reached for drive in drives),
        "contacts": sum(drive.contacts for drive in drives),
        "clearance_median_m": sorted(drive.clearance_m for drive in drives)[len(drives) // 2],
    }


def _ratio(drives: Sequence[DriveTime]) -> float:
    return sum(drive.time_s for drive in drives) / sum(drive.human_s for drive in drives)


def _cost(pairs: Sequence[tuple[DriveTime, DriveTime]]) -> float | None:
    """Pairs of (with, without); None for no drives."""
    if not pairs:
        return None
    return _ratio([pair[0] for pair in pairs]) - _ratio([pair[1] for pair in pairs])


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.margins", description=__doc__)
    parser.add_argument("folder", type=Path, help="drone recordings")
    parser.add_argument("--people", choices=PEOPLE, default="recorded", help="whether they heed the shuttle")
    parser.add_argument("--only", default="", metavar="NAMES", help="allowances, with commas between")
    parser.add_argument("--seed", type=int, default=1, help="of sensor noise")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
