"""The scenes of all drivers: random crowds, recorded cars' paths among people, and protection cells."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import msgspec

from campusloop.scenes.crowd_clips import clip_runs
from campusloop.scenes.drive import Scene
from campusloop.scenes.protection.braking_oracle import best_braking
from campusloop.scenes.protection.cell import Cell
from campusloop.scenes.protection.cells import cells
from campusloop.scenes.random_crowds import RandomScene, SceneSources, draw_scene, scene_sources
from campusloop.scenes.stacks import profile_of
from simulator.traffic.recordings import Clip, drone_clips
from vehicle_agent.config import Profile

_MAPS = Path(__file__).resolve().parents[2] / "maps"


@dataclass(frozen=True, slots=True)
class Case:
    """make gives the scene afresh for a vehicle: people remember, and are met once."""

    name: str
    kind: str
    make: Callable[[Profile], Scene]


def random_cases(seeds: range, recordings: Path | None) -> Iterator[Case]:
    """`sparse`, `dense` and, among recorded people, `replayed`."""
    found = scene_sources(tuple(sorted(_MAPS.glob("*/map.json"))), recordings)
    for seed in seeds:
        drawn = draw_scene(found, profile_of("snow_lion"), seed)
        yield Case(drawn.scene.name, _kind(drawn), partial(_drawn, found, seed))


def _kind(drawn: RandomScene) -> str:
    if drawn.crowd != "reactive":
        return "replayed"
    return "sparse" if drawn.is_sparse else "dense"


def _drawn(found: SceneSources, seed: int, profile: Profile) -> Scene:
    return draw_scene(found, profile, seed).scene


def clip_cases(folder: Path, seed: int) -> Iterator[Case]:
    """Every recorded drive below a folder, in the recorded car's place."""
    for clip in drone_clips(folder):
        for number, run in enumerate(clip_runs(clip, profile_of("snow_lion"), seed)):
            yield Case(run.scene.name, "clip", partial(_clip, clip, number, seed))


def _clip(clip: Clip, number: int, seed: int, profile: Profile) -> Scene:
    return clip_runs(clip, profile, seed)[number].scene


def cell_cases(count: int, seed: int) -> Iterator[Case]:
    """About `count` of the protection cells that an oracle's braking avoids, evenly taken from them all."""
    profile = profile_of("snow_lion")
    avoidable = [
        cell
        for cell in cells(profile.body)
        if best_braking(cell, profile.body, profile.lidar.x_m).impact_mps is None
    ]
    every = max(1, len(avoidable) // max(count, 1))
    for cell in avoidable[every // 2 :: every][:count]:
        yield Case(cell.name, "cell", partial(_cell, cell, seed))


def _cell(cell: Cell, seed: int, profile: Profile) -> Scene:
    return cell.scene(profile, seed)


def profile_for(stack: str) -> Profile:
    """The stack's vehicle at the Snow Lion shuttle's speed cap, so that none is safe only by being slow."""
    cap_mps = profile_of("snow_lion").limits.speed_mps_max
    profile = profile_of(stack)
    limits = msgspec.structs.replace(profile.limits, speed_mps_max=cap_mps)
    return msgspec.structs.replace(profile, limits=limits)


def short(scene: Scene, limit_s: float) -> Scene:
    """The same, given up sooner when its own limit is later."""
    return replace(scene, limit_s=min(scene.limit_s, limit_s))
