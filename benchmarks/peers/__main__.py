"""Other planners in our scenes: `make peers`, then `python -m benchmarks.peers --seeds N --json F`.

Random crowds (sparse to dense; `--recordings DIR` adds recorded people and every recorded car's drive) and
protection cells that can be avoided, each driven by our Snow Lion stack with its whole onboard loop, by the
GEM rule (stack gem, at the same cap), by pure pursuit (blind, and braking for people on its path) and by open
Frenet planners: CommonRoad's reactive planner and FISS+. A drive succeeds if it reaches the goal in the
scene's time without a front contact.

Everything is driven on two terms, in one run. `vehicle`: every planner answers the plan jobs of our vehicle,
with its noise, delays, controller, guard, by-wire and plant. `exact` (`NAME_exact`): exact poses, plans that
are followed exactly and at once, no guard; ours as well. `versus.X` compares X with ours on the same terms.

Open planners run in an environment and a process of their own; only their planning call is timed, as CPU.
`--drivers` and `--terms` select; with `--thin NAME=K` a slow one drives every Kth scene only.
"""

import argparse
import os
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from benchmarks.peers.drive import Driver, PeerDrive, road_of
from benchmarks.peers.on_vehicle import VehiclePeer
from benchmarks.peers.ours import OurPlanner
from benchmarks.peers.process import ROOT, PeerError, PeerProcess
from benchmarks.peers.pursuit import Pursuit
from benchmarks.peers.scenes import Case, cell_cases, clip_cases, profile_for, random_cases, short
from benchmarks.peers.score import EXACT, OURS, Result, result_of, summary
from benchmarks.reporting.report import RunReport
from campusloop.scenes.drive import Scene, SceneDrive, SceneRun
from simulator.traffic.recordings import RecordingError

PYTHON = ROOT / "var" / "peers" / "bin" / "python"
STACKS = (OURS, "gem")
TERMS = ("vehicle", "exact")
# A plan on the vehicle is followed beyond the next one's beginning.
_VEHICLE_STEPS = 150
RULES = {"pure_pursuit": True, "pure_pursuit_braking": False}
OPEN = {
    "reactive_default": ("reactive", "default"),
    "reactive_light": ("reactive", "light"),
    "fiss_default": ("fiss", "default"),
    "fiss_crowd": ("fiss", "crowd"),
    "fop_crowd": ("fiss", "fop"),
}


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    names = arguments.drivers.split(",")
    thin = dict(_thinned(text) for text in arguments.thin)
    unknown = [name for name in (*names, *thin) if name not in (*STACKS, *RULES, *OPEN)]
    if unknown:
        raise SystemExit(f"no driver {unknown[0]!r}; there are: {', '.join((*STACKS, *RULES, *OPEN))}")
    terms = arguments.terms.split(",")
    if not terms or set(terms) - set(TERMS):
        raise SystemExit(f"--terms takes {', '.join(TERMS)}, not {arguments.terms!r}")
    try:
        cases = _cases(arguments)
        with ExitStack() as stack:
            results, about = _drive_all(arguments, names, thin, cases, stack)
    except (RecordingError, PeerError) as error:
        raise SystemExit(f"cannot compare: {error}") from error
    report.write(
        arguments.json,
        "peers",
        {
            "seeds": arguments.seeds,
            "first_seed": arguments.first_seed,
            "cells": arguments.cells,
            "recordings": str(arguments.recordings or ""),
            "drivers": arguments.drivers,
            "terms": arguments.terms,
            "thin": arguments.thin,
            "limit_s": arguments.limit_s,
            "planning_s": arguments.planning_s,
            "open_planners": about,
        },
        [result.row() for result in results],
        summary(results),
    )


def _cases(arguments: argparse.Namespace) -> list[Case]:
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    cases = list(random_cases(seeds, arguments.recordings))
    if arguments.recordings is not None:
        cases += list(clip_cases(arguments.recordings, arguments.first_seed))
    if arguments.cells:
        cases += list(cell_cases(arguments.cells, arguments.first_seed))
    return cases


def _drive_all(
    arguments: argparse.Namespace, names: list[str], thin: dict[str, int], cases: list[Case], stack: ExitStack
) -> tuple[list[Result], list[str]]:
    """Drive scene by scene, so that the machine's state is the same for all drivers.

    Returns (results, descriptions of the open planners).
    """
    drivers: dict[str, Driver] = {}
    about = []
    for name in names:
        if name in OPEN:
            process = stack.enter_context(_open(arguments.python, name))
            about.append(f"{name}: {process.ready.name} {process.ready.version}, {process.ready.licence}")
            drivers[name] = process
    print("\n".join(about), flush=True)
    results = []
    for number, case in enumerate(cases):
        for name in names:
            if number % thin.get(name, 1) == 0:
                for result in _drive(name, drivers.get(name), case, arguments):
                    results.append(result)
                    print(_line(result), flush=True)
    return results, about


def _open(python: Path, name: str) -> PeerProcess:
    if not python.is_file():
        raise PeerError(f"{python} is not there: `make peers` installs the open planners, or give --python")
    return PeerProcess([str(python), "-m", "benchmarks.peers.serve", *OPEN[name]])


def _drive(name: str, driver: Driver | None, case: Case, arguments: argparse.Namespace) -> list[Result]:
    """On each of the terms that the driver knows: a stack that plans within its tick has no exact ones."""
    found = []
    if "vehicle" in arguments.terms:
        found.append(_on_vehicle(name, driver, case, arguments))
    if "exact" in arguments.terms and name != "gem":
        found.append(_exactly(name, driver, case, arguments))
    return found


def _on_vehicle(name: str, driver: Driver | None, case: Case, arguments: argparse.Namespace) -> Result:
    scene = short(case.make(profile_for(name if name in STACKS else OURS)), arguments.limit_s)
    if name in STACKS:
        return _result(name, case, scene, SceneDrive(scene).run(), arguments)
    driver = driver or Pursuit(RULES[name], _VEHICLE_STEPS)
    planner = VehiclePeer(scene, driver, arguments.planning_s)
    run = SceneDrive(scene, planner=planner).run()
    words = tuple(sorted(planner.words.items(), key=lambda item: -item[1]))
    run = replace(run, plan_cpu_ms=tuple(planner.cycles_cpu_ms), limited_by=words)
    return _result(name, case, scene, run, arguments, unfinished=planner.unfinished)


def _exactly(name: str, driver: Driver | None, case: Case, arguments: argparse.Namespace) -> Result:
    scene = short(case.make(profile_for(OURS)), arguments.limit_s)
    if driver is None:
        driver = OurPlanner(scene) if name == OURS else Pursuit(RULES[name])
    drive = PeerDrive(scene, driver, arguments.planning_s)
    run = drive.run()
    return _result(f"{name}{EXACT}", case, scene, run, arguments, unfinished=drive.unfinished)


def _result(
    name: str,
    case: Case,
    scene: Scene,
    run: SceneRun,
    arguments: argparse.Namespace,
    *,
    unfinished: bool = False,
) -> Result:
    if arguments.traces is not None:
        run.trace.write(arguments.traces / name, scene.name)
    cap_mps = road_of(scene).speed_mps_max
    return result_of(name, case.kind, scene, run, cap_mps, unfinished=unfinished)


def _line(result: Result) -> str:
    row = result.row()
    clearance = "-" if row["clearance_m"] is None else f"{row['clearance_m']:.2f}"
    cycle = "-" if row["cycle_p50_cpu_ms"] is None else f"{row['cycle_p50_cpu_ms']:.2f}"
    return (
        f"{result.scene} {result.kind} {result.driver}: {_end(result)}, "
        f"{result.driven_m:.0f} m in {result.time_s:.0f} s, contacts {result.contacts}+"
        f"{result.other_contacts}, clearance {clearance} m, cycle {cycle} ms, {row['words']}"
    )


def _end(result: Result) -> str:
    if result.unfinished:
        return "unfinished"
    return "reached" if result.reached else "not reached"


def _thinned(text: str) -> tuple[str, int]:
    name, _, every = text.partition("=")
    if not every.isdigit() or int(every) < 1:
        raise SystemExit(f"--thin needs NAME=K with K from 1 on, not {text!r}")
    return name, int(every)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.peers", description=__doc__)
    parser.add_argument("--seeds", type=int, default=12, help="random crowds")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--cells", type=int, default=12, help="protection cells; 0: none")
    parser.add_argument("--recordings", type=Path, help="folder of drone clips")
    parser.add_argument("--drivers", default=",".join((*STACKS, *RULES, *OPEN)), help="with commas between")
    parser.add_argument("--terms", default=",".join(TERMS), help="with commas between")
    parser.add_argument("--thin", action="append", default=[], help="NAME=K: drives every Kth scene only")
    parser.add_argument("--limit-s", type=float, default=90.0, help="a scene is given up by then")
    parser.add_argument("--planning-s", type=float, default=300.0, help="CPU that one drive's plans may take")
    parser.add_argument("--python", type=Path, default=PYTHON, help="interpreter with the open planners")
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--traces", type=Path, help="folder for two CSV files a run")
    return parser.parse_args()


if __name__ == "__main__":
    main()
