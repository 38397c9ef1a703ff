"""Drafts of motions, how wrong they are, and the stops that are there when a plan is not right."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.planning.motion.agents import MovingDiscs
from vehicle_agent.planning.motion.checker import violations
from vehicle_agent.planning.motion.path.gp_path import SolvedPath
from vehicle_agent.planning.motion.path.path_problem import Road
from vehicle_agent.planning.motion.path.path_samples import PathSamples, sample_path
from vehicle_agent.planning.motion.request import Motion, MotionParams, MotionRequest, Quality, WarmStart
from vehicle_agent.planning.motion.speed.profiles import (
    rows_on_arc,
    rows_on_path,
    stop_profiles,
    until_rest,
)
from vehicle_agent.planning.motion.speed.speed_step import SpeedSolution, plan_speed

_CONTACT = frozenset({"agent", "static", "footprint"})


class MotionCandidate(msgspec.Struct, frozen=True):
    """A path with its speed, rows and violations; `instead`: the violations of the plan that it replaces."""

    path: SolvedPath
    samples: PathSamples
    speed: SpeedSolution
    rows: np.ndarray
    quality: Quality
    wrong: tuple[str, ...]
    instead: tuple[str, ...] = ()


def judge(rows: Array, request: MotionRequest, params: MotionParams, quality: Quality) -> tuple[str, ...]:
    return violations(rows, request, params.vehicle, params.limits, emergency=quality == "emergency")


def badness(wrong: tuple[str, ...]) -> tuple[int, int]:
    """Contacts first, then the number of violations."""
    return len(_CONTACT.intersection(wrong)), len(wrong)


def stops(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    path: SolvedPath,
    samples: PathSamples,
    speed: SpeedSolution,
) -> tuple[MotionCandidate, ...]:
    """Stops on this path, the best first: the mildest without a violation, else the least bad hardest."""
    drafts: list[MotionCandidate] = []
    for quality, profile in stop_profiles(request.start, params.limits, params.row_s, params.horizon_s):
        rows = rows_on_path(until_rest(profile), samples, road.line, path)
        kind: Quality = "stop" if quality == "stop" else "emergency"
        draft = MotionCandidate(path, samples, speed, rows, kind, judge(rows, request, params, kind))
        if not draft.wrong:
            return (draft,)
        drafts.append(draft)
    # Of two that are equally wrong, the harder braking.
    return tuple(sorted(reversed(drafts), key=lambda draft: badness(draft.wrong)))  # noqa: C414


def safest(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    s0_m: float,
    start: Array,
    moving: MovingDiscs,
    draft: MotionCandidate,
) -> MotionCandidate:
    """The plan is not right: a stop on its path, or on the path before, whichever is less wrong."""
    choices = [*stops(request, params, road, draft.path, draft.samples, draft.speed)[:1], draft]
    if request.warm is not None and badness(choices[0].wrong) > (0, 0):
        old = _old_path(request.warm, s0_m, start, params)
        if old is not None:
            samples = sample_path(road.line, old, params.sample_m)
            speed = plan_speed(request, params, road, samples, moving, request.static_discs)
            choices += stops(request, params, road, old, samples, speed)[:1]
    best = min(choices, key=lambda choice: badness(choice.wrong))
    return msgspec.structs.replace(best, instead=draft.wrong)


def _old_path(warm: WarmStart, s0_m: float, start: Array, params: MotionParams) -> SolvedPath | None:
    """The path before from here on, when the vehicle is still on it."""
    steps = int((warm.s_m[-1] - s0_m) / params.step_m) if len(warm.s_m) >= 2 else 0
    if steps < 4:
        return None
    support = s0_m + params.step_m * np.arange(steps + 1)
    states = np.column_stack([np.interp(support, warm.s_m, warm.states[:, axis]) for axis in range(3)])
    if abs(states[0, 0] - start[0]) > 0.3:
        return None
    states[0] = start
    return SolvedPath(s0_m, params.step_m, states, math.inf, 0, False)


def on_arc(request: MotionRequest, params: MotionParams, why: str, moving: MovingDiscs) -> Motion:
    """A comfortable stop on the steering arc of now, harder when that would touch something."""
    s_m = request.s_hint_m if request.s_hint_m is not None else float(request.corridor.s_m[0])
    best: tuple[int, Array, Quality] | None = None
    for quality, profile in stop_profiles(request.start, params.limits, params.row_s, params.horizon_s):
        kind: Quality = "stop" if quality == "stop" else "emergency"
        rows = rows_on_arc(until_rest(profile), request.start, params.vehicle.curvature_1pm_max, s_m)
        hits = _CONTACT.intersection(judge(rows, request, params, kind))
        if best is None or len(hits) < best[0]:
            best = len(hits), rows, kind
        if not hits:
            break
    assert best is not None
    none = np.empty(0, np.int64)
    return Motion(
        best[1],
        None,
        False,
        (why,),
        "infeasible",
        best[2],
        0,
        none,
        none,
        np.inf,
        (("doubted", float(len(moving.doubted))),),
    )
