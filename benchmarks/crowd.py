"""Through recorded crowds: `python -m benchmarks.crowd DIR [--people aware] [--json F] [--traces DIR]`.

DIR holds drone recordings of cars among people. Every drive of a car forwards (mean of 0.5 m/s and more) is a
run: the shuttle drives that car's path among the recorded people and other cars. It begins with the car's
position, time and speed; its speed limit is the car's maximum in the drive. A front contact while moving
faster than 0.3 m/s counts, and a run that takes more than twice the human's time is a failure. The human's
drive is evaluated by the same rule, with the shuttle's outline. `dense_mps` is the mean speed while there are
5 to 8 people on the 100 m2 about the bumper, `dense_speed_ratio` its share of the speed limit. With `human_`
before them they are the human's.

The people are recorded. By default they see nothing, as the adversarial case. With `--people aware` they heed
the shuttle as they heeded the car; how well they then reproduce their recorded ways is printed.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from benchmarks.reporting.report import Row, RunReport
from benchmarks.reporting.run_logs import add_log_arguments, log_choice
from campusloop.commands.perceiving import tell_lacks
from campusloop.scenes.crowd_clips import PEOPLE, ClipRun, clip_runs
from campusloop.scenes.drive import SceneDrive, SceneRun
from campusloop.scenes.people_met import people_met
from campusloop.scenes.stacks import perceiving, profile_of
from simulator.traffic.aware.reproduction import Reproduction
from simulator.traffic.recordings import Clip, RecordingError, drone_clips
from vehicle_agent.config import ProfileError


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    logs = log_choice(arguments)
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    try:
        clips = drone_clips(arguments.folder)
        own = arguments.perception == "own"
        profiles = {stack: perceiving(profile_of(stack), own) for stack in arguments.stacks.split(",")}
    except (RecordingError, ProfileError) as error:
        raise SystemExit(f"cannot drive: {error}") from error
    for profile in profiles.values():
        tell_lacks(Console(), profile)
    for clip in clips:
        print(_recording_line(clip), flush=True)
    rows: list[Row] = []
    reproductions: list[Reproduction] = []
    for stack, profile in profiles.items():
        for clip in clips:
            for number, clip_run in enumerate(clip_runs(clip, profile, arguments.seed, arguments.people)):
                scene = clip_run.scene.with_plant(arguments.plant_seed)
                run = SceneDrive(scene, logs.of(clip_run.scene.name)).run()
                if arguments.traces is not None:
                    run.trace.write(arguments.traces / stack, clip_run.scene.name)
                rows.append(_row(stack, clip.name, number, clip_run, run))
                print(_line(rows[-1]), flush=True)
                if arguments.people == "aware":
                    reproductions.append(clip_run.reproduction(clip, profile.body))
    report.write(
        arguments.json,
        "crowd",
        {
            "folder": str(arguments.folder),
            "stacks": arguments.stacks,
            "perception": arguments.perception,
            "people": arguments.people,
            "seed": arguments.seed,
        }
        | {"plant_seed": arguments.plant_seed},
        rows,
        summary(rows) | people_summary(rows, reproductions),
    )


def _recording_line(clip: Clip) -> str:
    people = sum(not track.is_driven for track in clip.tracks)
    done = clip.repairs
    return (
        f"{clip.name}: {clip.fps:.2f} frames/s, {people} people, {len(clip.cars())} cars; "
        f"{done.bridged_gaps} gaps bridged, {done.cuts} tracks cut, {done.dropped_rows} rows dropped"
    )


def _row(stack: str, clip: str, number: int, clip_run: ClipRun, run: SceneRun) -> Row:
    limit_s = clip_run.scene.limit_s
    cpu_ms = run.plan_cpu_ms or (0.0,)
    met = people_met(run.trace.array(), run.trace.agents, clip_run.scene.profile.body)
    return {
        "stack": stack,
        "clip": clip,
        "run": number,
        "human_s": clip_run.human_time_s,
        "human_max_mps": clip_run.human_max_mps,
        "time_s": run.time_s if run.time_s is not None else limit_s,
        "reached": run.time_s is not None,
        "contacts": len(run.metrics.front_contacts),
        "other_contacts": len(run.metrics.other_contacts),
        "people_removed": len(clip_run.traffic.removed),
        "people_removed_at": " ".join(
            f"{number}:({x:.1f},{y:.1f})@{t_s:.1f}s"
            for number, (t_s, x, y) in clip_run.traffic.removed.items()
        ),
        "people_delayed": len(clip_run.traffic.delayed),
        "clearance_m": _finite(run.metrics.clearance_m),
        "human_contacts": len(clip_run.human.front_contacts),
        "human_clearance_m": _finite(clip_run.human.clearance_m),
        "dense_s": met.dense_s,
        "dense_m": met.dense_m,
        "human_dense_s": clip_run.human_met.dense_s,
        "human_dense_m": clip_run.human_met.dense_m,
        "plan_cpu_p95_ms": float(np.percentile(cpu_ms, 95)),
        "limited_by": " ".join(f"{name}:{count}" for name, count in run.limited_by[:4]),
    }


def summary(rows: list[Row]) -> dict[str, float | int | None]:
    """Per stack; every clip and every run counts, a failed one with the time limit as its time."""
    out: dict[str, float | int | None] = {}
    for stack in dict.fromkeys(str(row["stack"]) for row in rows):
        mine = [row for row in rows if row["stack"] == stack]
        human_s = sum(_number(row["human_s"]) for row in mine)
        clear = [_number(row["clearance_m"]) for row in mine if row["clearance_m"] is not None]
        human_clear = [
            _number(row["human_clearance_m"]) for row in mine if row["human_clearance_m"] is not None
        ]
        out[f"{stack}.runs"] = len(mine)
        out[f"{stack}.contacts"] = int(sum(_number(row["contacts"]) for row in mine))
        out[f"{stack}.failures"] = sum(not row["reached"] for row in mine)
        out[f"{stack}.time_ratio"] = (
            sum(_number(row["time_s"]) for row in mine) / human_s if human_s else None
        )
        out[f"{stack}.clearance_median_m"] = float(np.median(clear)) if clear else None
        out[f"{stack}.human_contacts"] = int(sum(_number(row["human_contacts"]) for row in mine))
        out[f"{stack}.human_clearance_median_m"] = float(np.median(human_clear)) if human_clear else None
        for whose in ("", "human_"):
            dense_m = sum(_number(row[f"{whose}dense_m"]) for row in mine)
            dense_s = sum(_number(row[f"{whose}dense_s"]) for row in mine)
            out[f"{stack}.{whose}dense_mps"] = dense_m / dense_s if dense_s else None
            limits_m = sum(_number(row[f"{whose}dense_s"]) * _number(row["human_max_mps"]) for row in mine)
            out[f"{stack}.{whose}dense_speed_ratio"] = dense_m / limits_m if limits_m else None
    return out


def people_summary(rows: list[Row], reproductions: Sequence[Reproduction]) -> dict[str, float | int | None]:
    """How many people were taken out; of aware people also the mean displacements (`Reproduction`)."""
    out: dict[str, float | int | None] = {
        "people.removed": int(sum(_number(row["people_removed"]) for row in rows)),
        "people.delayed": int(sum(_number(row["people_delayed"]) for row in rows)),
    }
    if reproductions:
        out["people.displacement_m"] = _mean([r.deployed_m for r in reproductions])
        out["people.population_displacement_m"] = _mean([r.population_m for r in reproductions])
        out["people.recreated_displacement_m"] = _mean([r.recreated_m for r in reproductions])
        out["people.unheeding_displacement_m"] = _mean([r.unheeding_m for r in reproductions])
    return out


def _mean(samples: Sequence[np.ndarray]) -> float | None:
    together = np.concatenate(samples)
    return float(together.mean()) if len(together) else None


def _number(value: object) -> float:
    assert isinstance(value, int | float)
    return float(value)


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _line(row: Row) -> str:
    removed = f", removed {row['people_removed_at']}" if row["people_removed"] else ""
    return (
        f"{row['stack']} {row['clip']} {row['run']}: {row['time_s']:.1f} s (human {row['human_s']:.1f}), "
        f"contacts {row['contacts']}+{row['other_contacts']}, {row['people_removed']} people removed, "
        f"clearance {row['clearance_m']} (human {row['human_clearance_m']}), {row['limited_by']}{removed}"
    )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.crowd", description=__doc__)
    parser.add_argument("folder", type=Path, help="drone recordings")
    parser.add_argument("--people", choices=PEOPLE, default="recorded", help="whether they heed the shuttle")
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--traces", type=Path, help="folder for two CSV files a run")
    parser.add_argument("--stacks", default="snow_lion,gem,nus", help="with commas between")
    parser.add_argument("--seed", type=int, default=1, help="of sensor noise")
    parser.add_argument("--plant-seed", type=int, help="of the vehicle's dynamics; nominal without it")
    parser.add_argument(
        "--perception",
        choices=("tracker", "own"),
        default="tracker",
        help="road users by a tracker of the truth with noise, or found in simulated scans",
    )
    add_log_arguments(parser)
    return parser.parse_args()


if __name__ == "__main__":
    main()
