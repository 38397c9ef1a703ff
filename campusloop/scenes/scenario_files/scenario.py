"""Drives a scenario file as a scene and compares the run with the file's expectations."""

import math
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from campusloop.scenes.drive import Scene, SceneDrive, SceneError, SceneRun
from campusloop.scenes.faults import CameraError
from campusloop.scenes.other_shuttle import OtherRoad
from campusloop.scenes.path_map import LANE_ID, path_map
from campusloop.scenes.scenario_files.actors import actors_of
from campusloop.scenes.scenario_files.road_users import OtherShuttle
from campusloop.scenes.scenario_files.scenario_file import (
    Expectations,
    Occluder,
    Road,
    ScenarioError,
    ScenarioFile,
)
from contract.geometry import Array, arc_lengths, pose_at
from contract.roads.load import MapError, load_map
from contract.roads.model import Building, ObservationArea, RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import Route, find_route, route_line
from simulator.sensors.tracker import TrackerNoise
from simulator.world import WorldOptions
from vehicle_agent.config import Profile

_BEFORE_END_M = 6.0
_STANDS_MPS = 0.05
_MOVED_M = 0.05
_STOOD_ROWS = 25


@dataclass(frozen=True, slots=True)
class Outcome:
    """failures: the expectations that were not met; empty: passed."""

    run: SceneRun
    failures: tuple[str, ...]


def scene_of(found: ScenarioFile, name: str, profile: Profile, folder: Path) -> Scene:
    """The file's scene. folder: of the file; its map's path is relative to it. Raises ScenarioError."""
    road, shuttle = found.road, found.shuttle
    walls = tuple(_building(one) for one in found.occluder)
    route: Route | None = None
    if road.map:
        road_map, route = _campus(road, walls, folder, name)
        length_m, start_s_m = route.length_m, 0.0
        points = route_line(RoadNetwork(road_map), route).points
    else:
        points = np.array(road.path, dtype=np.float64)
        try:
            road_map = path_map(
                name, points, width_m=road.width_m, speed_limit_mps=road.speed_limit_mps,
                scenario=road.scenario, buildings=walls, areas=_areas(road, points),
            )  # fmt: skip
        except ValueError as error:
            raise ScenarioError(f"{name}: {error} - at `$.road.path`") from error
        length_m, start_s_m = float(arc_lengths(points)[-1]), shuttle.start_s_m
    goal_s_m = shuttle.goal_s_m if shuttle.goal_s_m is not None else length_m - _BEFORE_END_M
    if not start_s_m < goal_s_m <= length_m:
        raise ScenarioError(
            f"{name}: the goal is not on the {length_m:.1f} m ahead - at `$.shuttle.goal_s_m`"
        )
    if shuttle.speed_mps_max > 0.0:
        limits = msgspec.structs.replace(profile.limits, speed_mps_max=shuttle.speed_mps_max)
        profile = msgspec.structs.replace(profile, limits=limits)
    noise = found.noise
    tracker = TrackerNoise(dropout_ratio=noise.dropout_ratio, latency_ns=round(1e9 * noise.latency_s))
    return Scene(
        name=name,
        road_map=road_map,
        profile=profile,
        start_s_m=start_s_m,
        start_mps=shuttle.start_mps,
        goal_s_m=goal_s_m,
        limit_s=found.max_time_s,
        seed=found.seed,
        actors=actors_of(found, points),
        options=WorldOptions(traffic=None, tracker=tracker),
        route=route,
        faults=found.fault,
        cameras=found.camera,
        resumes_s=tuple(sorted(found.operator.resume_s)),
        stop_id=road.to_stop,
        others=tuple(_other(one, walls, name, k) for k, one in enumerate(found.other_shuttle)),
    )


def drive(
    found: ScenarioFile,
    name: str,
    profile: Profile,
    folder: Path,
    runs: Path | None,
    plant_seed: int | None = None,
) -> Outcome:
    """Drive a scenario. Raises ScenarioError.

    runs        folder of the run log, None for no log
    plant_seed  of the shuttles' dynamics; None: nominal ones
    """
    try:
        run = SceneDrive(scene_of(found, name, profile, folder).with_plant(plant_seed), runs).run()
    except (SceneError, CameraError) as error:
        raise ScenarioError(str(error)) from error
    return Outcome(run, unmet_expectations(found.expect, run))


def unmet_expectations(expect: Expectations, run: SceneRun) -> tuple[str, ...]:
    """The expectations that the run does not meet, as texts."""
    rows, out = run.trace.array(), []
    fronts = [*run.metrics.front_contacts, *(hit for one in run.others for hit in one.metrics.front_contacts)]
    if len(fronts) > expect.contacts:
        at_s, number, speed_mps = fronts[0]
        out.append(
            f"{len(fronts)} front contacts, the first with {number} at {at_s:.1f} s, {speed_mps:.1f} m/s"
        )
    if expect.reaches_goal is not None and expect.reaches_goal != (run.time_s is not None):
        out.append(f"drove only {run.driven_m:.1f} m" if expect.reaches_goal else "reached the goal")
    if expect.time_s_max is not None and (run.time_s is None or run.time_s > expect.time_s_max):
        taken = "never" if run.time_s is None else f"after {run.time_s:.1f} s"
        out.append(f"at the goal {taken}, not within {expect.time_s_max:g} s")
    if expect.clearance_m_min is not None and run.metrics.clearance_m < expect.clearance_m_min:
        out.append(f"clearance {run.metrics.clearance_m:.2f} m, not {expect.clearance_m_min:g} m")
    for number, other in enumerate(run.others, start=2):
        if expect.others_arrive is not None and other.arrived != expect.others_arrive:
            out.append(f"shuttle {number} {'arrived' if other.arrived else 'did not arrive'}")
    out += _unmet_positions(expect, run, rows)
    hardest = _hardest_mps2(rows)
    if expect.decel_mps2_max is not None and hardest > expect.decel_mps2_max:
        out.append(f"braked with {hardest:.2f} m/s2, more than {expect.decel_mps2_max:g}")
    reported = " | ".join((*run.reported, *(name for name, _ in run.limited_by)))
    out += [f"never reported {text!r}; reported: {reported}" for text in expect.says if text not in reported]
    out += [f"reported {text!r}" for text in expect.never_says if text in reported]
    return tuple(out)


def _unmet_positions(expect: Expectations, run: SceneRun, rows: Array) -> list[str]:
    """The unmet expectations on positions along the road."""
    out, s_m = [], np.array(run.way_m)
    still = np.abs(rows[:, 4]) < _STANDS_MPS
    stood = np.convolve(still, np.ones(_STOOD_ROWS), "full")[: len(still)] >= _STOOD_ROWS
    moved = np.maximum.accumulate(np.abs(rows[:, 4])) > 0.5
    if expect.stops_before_s_m is not None:
        before = stood & moved & (np.maximum.accumulate(s_m) < expect.stops_before_s_m)
        if not before.any():
            out.append(f"did not stop before {expect.stops_before_s_m:g} m")
    if expect.never_passes_s_m is not None and s_m.max() > expect.never_passes_s_m:
        out.append(f"came to {s_m.max():.1f} m, beyond {expect.never_passes_s_m:g} m")
    if expect.stands_until_s is not None:
        begun_s = rows[np.hypot(*(rows[:, 1:3] - rows[0, 1:3]).T) > _MOVED_M, 0]
        if len(begun_s) and begun_s[0] < expect.stands_until_s:
            out.append(f"set off at {begun_s[0]:.1f} s, before {expect.stands_until_s:g} s")
    if expect.stands_s_min is not None:
        stands_s = float((still & moved).sum()) * 0.02
        if stands_s < expect.stands_s_min:
            out.append(f"stood for {stands_s:.1f} s, not {expect.stands_s_min:g} s")
    return out


def _hardest_mps2(rows: Array) -> float:
    """The hardest braking as a mean over 0.1 s."""
    if len(rows) < 6:
        return 0.0
    return float(((np.abs(rows[:-5, 4]) - np.abs(rows[5:, 4])) / 0.1).max())


def _campus(road: Road, walls: tuple[Building, ...], folder: Path, name: str) -> tuple[RoadMap, Route]:
    try:
        road_map = load_map(folder / road.map)
    except MapError as error:
        raise ScenarioError(f"{name}: {error} - at `$.road.map`") from error
    stops = {stop.stop_id: stop for stop in road_map.stops}
    for field in ("from_stop", "to_stop"):
        if getattr(road, field) not in stops:
            raise ScenarioError(f"{name}: the map has no such stop - at `$.road.{field}`")
    begin, end = stops[road.from_stop], stops[road.to_stop]
    route = find_route(RoadNetwork(road_map), begin.lane_id, begin.s_m, end.lane_id, end.s_m)
    if route is None or route.length_m < _BEFORE_END_M + 1.0:
        raise ScenarioError(f"{name}: there is no route between these stops - at `$.road.to_stop`")
    return msgspec.structs.replace(road_map, buildings=(*road_map.buildings, *walls)), route


def _areas(road: Road, points: Array) -> tuple[ObservationArea, ...]:
    s = arc_lengths(points)
    found = []
    for area in road.area:
        x, y, yaw = pose_at(points, s, area.s_m + 0.5 * area.length_m)
        outline = _box(x, y, yaw, area.length_m, 2.0 * area.reach_m)
        stop_line = (LANE_ID, max(0.0, area.s_m - 0.5))
        found.append(ObservationArea(area.id, area.kind, outline, (stop_line,)))
    return tuple(found)


def _building(one: Occluder) -> Building:
    outline = _box(*one.at, math.radians(one.heading_deg), one.length_m, one.width_m)
    return Building(outline, one.height_m)


def _box(x: float, y: float, yaw: float, length: float, width: float) -> tuple[tuple[float, float], ...]:
    cos, sin = math.cos(yaw), math.sin(yaw)
    corners = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    return tuple(
        (x + u * length * cos - v * width * sin, y + u * length * sin + v * width * cos) for u, v in corners
    )


def _other(one: OtherShuttle, walls: tuple[Building, ...], name: str, number: int) -> OtherRoad:
    field = f"other_shuttle[{number}]"
    points = np.array(one.path, dtype=np.float64)
    try:
        road_map = path_map(
            f"{name}-{number + 2}", points, width_m=one.width_m, speed_limit_mps=one.speed_limit_mps,
            buildings=walls,
        )  # fmt: skip
    except ValueError as error:
        raise ScenarioError(f"{name}: {error} - at `$.{field}.path`") from error
    if one.start_s_m >= float(arc_lengths(points)[-1]) - _BEFORE_END_M:
        raise ScenarioError(f"{name}: the start is not on the path - at `$.{field}.start_s_m`")
    return OtherRoad(road_map, one.start_s_m, one.start_mps)
