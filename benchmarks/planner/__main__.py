"""Time and validity of motion plans: `python -m benchmarks.planner --seeds N --json F`.

Random campus scenes with 50 others (people walking, standing, cyclists, cars) over 8 s and 40 m, on the
shipped maps and on synthetic bends, from 0 to 20 km/h; each is followed in closed loop for some plans with
warm start. One plan is behaviour, path, speed and checks. A plan is feasible if the independent checker
(vehicle_agent/planning/motion/checker.py) accepts it; a road user inside the outline requires a stop.
`--traces DIR` writes every request's trajectory; `--oracle` compares the path with gtsam's optimum.
"""

import argparse
import gc
import os
import time
from collections import Counter
from pathlib import Path

import numpy as np

from benchmarks.planner.clearance_grid import clearance_grid
from benchmarks.planner.scenes import Scene, SceneMaker
from benchmarks.reporting.report import Row, RunReport
from contract.geometry import Array
from vehicle_agent.planning.behaviour.crossing_traffic import CrossingRules
from vehicle_agent.planning.behaviour.decide import BehaviourRules, Decision, decide
from vehicle_agent.planning.motion.checker import violations
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import Motion, MotionParams, MotionRequest
from vehicle_agent.signals import NO_VIEW, PlanJob, PlanMemory, Predictions, Tracks

PARAMS = MotionParams()
RULES = BehaviourRules(
    front_m=PARAMS.vehicle.box.front_m,
    back_m=PARAMS.vehicle.rear_overhang_m,
    half_width_m=0.5 * PARAMS.vehicle.width_m,
    crossing=CrossingRules(PARAMS.vehicle.box.front_m),
)
_STEP_S = 0.2


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    maker = SceneMaker()
    for seed in (-1, -2, -3):  # compile
        for _ in range(2):
            plan_once(maker.scene(10_000_000 - seed))
    gc.collect()
    gc.freeze()
    rows: list[Row] = []
    for seed in range(arguments.first_seed, arguments.first_seed + arguments.seeds):
        scene = maker.scene(seed)
        rows += follow(scene, arguments.plans, seed, arguments.traces)
    summary = _summary(rows)
    summary |= grid_figures(maker)
    if arguments.oracle:
        from benchmarks.planner.oracle import oracle_figures

        summary |= oracle_figures(maker, min(arguments.seeds, 10))
    print(Counter(str(row["violations"]) for row in rows if not row["feasible"]).most_common(12))
    print(Counter(str(row["quality"]) for row in rows), Counter(str(row["limited_by"]) for row in rows))
    kept = ("seeds", "first_seed", "plans")
    shown = rows if arguments.json is None or len(rows) <= 5000 else rows[:5000]
    report.write(
        arguments.json,
        "planner",
        {name: getattr(arguments, name) for name in kept} | {"cores_used": 1},
        shown if arguments.json is not None else rows[-5:],
        summary,
    )


def follow(scene: Scene, plans: int, seed: int, traces: Path | None) -> list[Row]:
    """One row a plan, in closed loop."""
    random = np.random.default_rng([seed, 7])
    rows: list[Row] = []
    for number in range(plans):
        cpu, wall = time.process_time_ns(), time.perf_counter_ns()
        request, motion = plan_once(scene)
        cpu, wall = time.process_time_ns() - cpu, time.perf_counter_ns() - wall
        wrong = violations(
            motion.rows,
            request,
            PARAMS.vehicle,
            PARAMS.limits,
            emergency=motion.quality == "emergency",
        )
        figures = dict(motion.diagnostics)
        rows.append(
            {
                "scene": scene.name,
                "plan": number,
                "cpu_ms": cpu * 1e-6,
                "wall_ms": wall * 1e-6,
                "feasible": not wrong and motion.violations == (),
                "violations": " ".join(wrong or motion.violations),
                "quality": motion.quality,
                "limited_by": motion.limited_by,
                "iterations": motion.iterations,
                "path_iterations": figures.get("path_iterations"),
                "search_nodes": figures.get("search_nodes"),
                "start_mps": scene.start.speed_mps,
                "way_m": float(motion.rows[-1, 7] - motion.rows[0, 7]),
            }
        )
        if traces is not None:
            traces.mkdir(parents=True, exist_ok=True)
            header = "t_s,x_m,y_m,yaw_rad,curvature_1pm,speed_mps,accel_mps2,s_m"
            name = f"{scene.name.replace(' ', '-')}-{number}.csv"
            np.savetxt(traces / name, motion.rows, "%.6f", ",", header=header, comments="")
        scene.advance(motion, _STEP_S, random)
    return rows


def plan_once(scene: Scene) -> tuple[MotionRequest, Motion]:
    """Behaviour, then motion; what both want to remember is kept in the scene."""
    job = _job(scene)
    decision = decide(job, RULES)
    request = _request(scene, job, decision)
    motion = plan_motion(request, PARAMS)
    chosen = decision.chosen
    scene.memory = PlanMemory(
        chosen.offset_m,
        chosen.better_offset_m,
        chosen.better_count,
        stopping_for=decision.yielding.stopping_for,
    )
    scene.warm = motion.path
    return request, motion


def _job(scene: Scene) -> PlanJob:
    start = scene.start
    t, poses = scene.predictions()
    heading = np.column_stack([np.cos(scene.poses_map[:, 2]), np.sin(scene.poses_map[:, 2])])
    ids = np.arange(len(scene.kinds), dtype=np.int64)
    velocities = heading * scene.speeds_mps[:, None]
    tracks = Tracks(1, ids, scene.kinds, scene.poses_map.copy(), velocities, scene.sizes_m)
    sigmas = np.repeat((0.1 + 0.12 * t)[None], len(ids), axis=0)
    memory = scene.memory if isinstance(scene.memory, PlanMemory) else PlanMemory()
    return PlanJob(
        1, 1, 1, start.pose_map, start.speed_mps, start.accel_mps2, start.curvature_1pm, scene.corridor(),
        scene.stop_s_m, "stop", PARAMS.limits.speed_mps_max, "speed_limit", scene.static_points, tracks,
        Predictions(1, t, poses, sigmas), NO_VIEW, (), (), memory,
    )  # fmt: skip


def _request(scene: Scene, job: PlanJob, decision: Decision) -> MotionRequest:
    must_yield = np.isin(job.tracks.ids, decision.yielding.to).astype(np.int64)
    return MotionRequest(
        job.corridor,
        scene.start,
        decision.reference_l_m,
        decision.lower_l_m,
        decision.upper_l_m,
        decision.speed_mps_max,
        decision.end_s_m,
        decision.discs,
        scene.agents(decision.inflation_m, must_yield),
        scene.warm,  # type: ignore[arg-type]
        decision.s_m,
    )


def grid_figures(maker: SceneMaker) -> Row:
    """The s-l-t grid (60 x 15 x 50 among 50 others) with the early-out by clearance and without it."""
    times: dict[bool, list[float]] = {True: [], False: []}
    share = []
    for seed in range(20):
        poses, discs = _grid_inputs(maker.scene(seed))
        for early_out in (False, True):
            begun = time.process_time_ns()
            grid, computed = clearance_grid(poses, discs, PARAMS.vehicle.box, 1.6, early_out=early_out)
            times[early_out].append((time.process_time_ns() - begun) * 1e-6)
        share.append(computed / grid.size)
    return {
        "grid_ms": float(np.median(times[True][1:])),
        "grid_brute_ms": float(np.median(times[False][1:])),
        "grid_cells_computed_pct": 100.0 * float(np.mean(share)),
    }


def _grid_inputs(scene: Scene) -> tuple[Array, Array]:
    """(60, 15, 3) poses on the corridor's parallels, and (50, 50, 3) everybody as a disc every 0.16 s."""
    corridor = scene.corridor()
    first = int(np.searchsorted(corridor.s_m, scene.s_m))
    at = np.minimum(first + np.arange(60), len(corridor.s_m) - 1)
    offsets = np.linspace(-1.4, 1.4, 15)
    yaw = np.repeat(corridor.yaw_rad[at][:, None], 15, axis=1)
    x = corridor.points_map[at, 0][:, None] - offsets * np.sin(yaw)
    y = corridor.points_map[at, 1][:, None] + offsets * np.cos(yaw)
    t, places = scene.predictions()
    want = 0.16 * np.arange(50)
    discs = np.empty((50, len(scene.kinds), 3))
    for a in range(len(scene.kinds)):
        for axis in range(2):
            discs[:, a, axis] = np.interp(want, t, places[a, :, axis])
    discs[:, :, 2] = 0.5 * scene.sizes_m.max(axis=1)
    return np.stack([x, y, yaw], axis=2), discs


def _summary(rows: list[Row]) -> Row:
    cpu = np.array([row["cpu_ms"] for row in rows], dtype=np.float64)
    wall = np.array([row["wall_ms"] for row in rows], dtype=np.float64)
    return {
        "plans": len(rows),
        "p50_cpu_ms": float(np.percentile(cpu, 50)),
        "p95_cpu_ms": float(np.percentile(cpu, 95)),
        "p99_cpu_ms": float(np.percentile(cpu, 99)),
        "p99_wall_ms": float(np.percentile(wall, 99)),
        "feasible_pct": 100.0 * float(np.mean([bool(row["feasible"]) for row in rows])),
        "emergency_pct": 100.0 * float(np.mean([row["quality"] == "emergency" for row in rows])),
        "stop_pct": 100.0 * float(np.mean([row["quality"] == "stop" for row in rows])),
        "mean_way_m": float(np.mean([row["way_m"] for row in rows])),  # type: ignore[arg-type]
    }


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.planner", description=__doc__)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--seeds", type=int, default=200, help="number of scenes")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--plans", type=int, default=8, help="plans in closed loop a scene, 0.2 s apart")
    parser.add_argument("--traces", type=Path, help="folder for one CSV a plan")
    parser.add_argument("--oracle", action="store_true", help="compare with gtsam (extra `oracle`)")
    return parser.parse_args()


if __name__ == "__main__":
    main()
