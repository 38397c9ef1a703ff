"""Random campus scenes for the motion planner: a stretch of road, a shuttle on it, fifty others around it."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.random import Generator, default_rng

from contract.geometry import Array, Pose2
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_line
from vehicle_agent.planning.motion.checker import violations
from vehicle_agent.planning.motion.corridor import corridor_of, window
from vehicle_agent.planning.motion.request import (
    Agents,
    Motion,
    MotionParams,
    MotionRequest,
    StartState,
)
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE, Corridor

MAPS = Path(__file__).resolve().parents[2] / "maps"
PREDICTED_S, STEP_S = 8.0, 0.25
_BEHIND_M, _AHEAD_M = 8.0, 55.0
_SIZES = {PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.8, 0.6), VEHICLE: (4.4, 1.8)}


@dataclass(slots=True)
class Scene:
    """A shuttle at `start` (s_m on the road) among moving and standing others; everything in the map frame.

    kinds (a,), poses_map (a, 3), speeds_mps (a,), sizes_m (a, 2); static_points (m, 2) of kerbs and trees
    """

    name: str
    road: Corridor
    start: StartState
    s_m: float
    kinds: Array
    poses_map: Array
    speeds_mps: Array
    sizes_m: Array
    static_points: Array
    stop_s_m: float
    memory: object = None
    warm: object = field(default=None)

    def corridor(self) -> Corridor:
        return window(self.road, self.s_m, _BEHIND_M, _AHEAD_M)

    def predictions(self) -> tuple[Array, Array]:
        """((k,) times, (a, k, 3) poses) at constant velocity."""
        t = STEP_S * np.arange(round(PREDICTED_S / STEP_S) + 1)
        way = self.speeds_mps[:, None] * t
        yaw = np.repeat(self.poses_map[:, 2:3], len(t), axis=1)
        x = self.poses_map[:, :1] + way * np.cos(yaw)
        y = self.poses_map[:, 1:2] + way * np.sin(yaw)
        return t, np.stack([x, y, yaw], axis=2)

    def agents(self, inflation_m: Array, pass_rule: Array) -> Agents:
        t, poses = self.predictions()
        ids = np.arange(len(self.kinds), dtype=np.int64)
        return Agents(ids, self.kinds, t, poses, self.sizes_m, inflation_m, pass_rule)

    def advance(self, motion: Motion, dt_s: float, random: Generator) -> None:
        """The shuttle follows the rows for dt_s with a little error; others walk on and stop short of it."""
        rows = motion.rows
        t = min(dt_s, float(rows[-1, 0]))
        x, y, yaw, kappa, v, a = (float(np.interp(t, rows[:, 0], rows[:, i])) for i in range(1, 7))
        pose = Pose2(
            x + random.normal(0.0, 0.01), y + random.normal(0.0, 0.01), yaw + random.normal(0.0, 0.002)
        )
        self.start = StartState(pose, v, a if v > 0.0 else 0.0, kappa)
        self.s_m = float(np.interp(t, rows[:, 0], rows[:, 7]))
        self.poses_map[:, 2] += random.normal(0.0, 0.03, len(self.kinds)) * (self.speeds_mps > 0.0)
        step = self.speeds_mps * dt_s
        ahead = self.poses_map[:, :2] + (step + 0.4)[:, None] * np.column_stack(
            [np.cos(self.poses_map[:, 2]), np.sin(self.poses_map[:, 2])]
        )
        free = outline_distance(pose, ahead) > 0.5 * self.sizes_m.max(axis=1)
        moved = np.where(free, step, 0.0)
        self.poses_map[:, 0] += moved * np.cos(self.poses_map[:, 2])
        self.poses_map[:, 1] += moved * np.sin(self.poses_map[:, 2])


def outline_distance(pose: Pose2, points: Array) -> Array:
    """(m,) how far points (m, 2) are from the shuttle's outline; 0 inside."""
    vehicle = MotionParams().vehicle
    dx, dy = points[:, 0] - pose.x_m, points[:, 1] - pose.y_m
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    middle = 0.5 * vehicle.length_m - vehicle.rear_overhang_m
    along = np.abs(cos * dx + sin * dy - middle) - 0.5 * vehicle.length_m
    aside = np.abs(cos * dy - sin * dx) - 0.5 * vehicle.width_m
    distance: Array = np.hypot(np.maximum(along, 0.0), np.maximum(aside, 0.0))
    return distance


class SceneMaker:
    """Scenes by seed, on every shipped map and on synthetic bends."""

    def __init__(self, maps: tuple[Path, ...] = ()) -> None:
        files = maps or tuple(sorted(MAPS.glob("*/map.json")))
        self._networks = [RoadNetwork(load_map(file)) for file in files]

    def scene(self, seed: int, agents: int = 50) -> Scene:
        random = default_rng(seed)
        which = int(random.integers(len(self._networks) + 1))
        if which < len(self._networks):
            name, road = f"map {which}", self._route(self._networks[which], random)
        else:
            name, road = "bends", _bends(random)
        last = float(road.s_m[-1])
        s_m = float(random.uniform(0.0, max(1.0, last - 45.0)))
        limit_mps = float(np.interp(s_m, road.s_m, road.limit_mps))
        kappa = float(np.interp(s_m, road.s_m, road.curvature_1pm))
        # Nobody arrives at a curve faster than braking at 0.6 m/s2 allows.
        ahead = road.s_m >= s_m
        curve = 0.75 / np.maximum(np.abs(road.curvature_1pm[ahead]), 1e-6)
        arrival = np.sqrt(curve + 1.2 * np.maximum(road.s_m[ahead] - s_m - 3.0, 0.0))
        fastest = float(min(20.0 / 3.6, arrival.min(), limit_mps + 1.4))
        speed = float(random.choice([0.0, random.uniform(0.0, fastest), fastest]))
        offset = float(np.clip(random.normal(0.0, 0.15), -0.4, 0.4))
        x, y = (float(np.interp(s_m, road.s_m, road.points_map[:, i])) for i in range(2))
        yaw = float(np.interp(s_m, road.s_m, road.yaw_rad))
        pose = Pose2(
            x - offset * math.sin(yaw), y + offset * math.cos(yaw), yaw + float(random.normal(0.0, 0.02))
        )
        start = StartState(pose, speed, 0.0, float(np.clip(kappa, -0.19, 0.19)))
        kinds, poses, speeds, sizes = self._others(road, s_m, pose, speed, agents, random)
        ends = s_m + random.uniform(10.0, 60.0) if random.uniform() < 0.3 else math.inf
        static = _roadside(road, s_m, pose, random)
        scene = Scene(f"{name} {seed}", road, start, s_m, kinds, poses, speeds, sizes, static, ends)
        _leave_way_out(scene)
        return scene

    def _route(self, network: RoadNetwork, random: Generator) -> Corridor:
        lanes = list(network.lines)
        while True:
            first, last = (lanes[int(i)] for i in random.integers(len(lanes), size=2))
            route = find_route(network, first, 0.0, last, network.lines[last].length_m)
            if route is not None and route.length_m > 60.0:
                return corridor_of(route_line(network, route), network)

    def _others(
        self, road: Corridor, s_m: float, pose: Pose2, speed: float, agents: int, random: Generator
    ) -> tuple[Array, Array, Array, Array]:
        """People walking along and across, standing beside, cyclists along, cars along and parked."""
        kinds, poses, speeds = [], [], []
        inside = random.uniform() < 0.01
        while len(kinds) < agents:
            at = s_m + float(random.uniform(-12.0, 50.0))
            x, y, yaw = _on_road(road, at)
            role = random.uniform()
            aside = float(random.uniform(-10.0, 10.0))
            if role < 0.35:
                kind, v, turn = PEDESTRIAN, random.normal(1.3, 0.25), random.uniform(-math.pi, math.pi)
            elif role < 0.55:
                kind, v = PEDESTRIAN, random.normal(1.3, 0.25)
                turn = random.normal(0.0, 0.15) + (math.pi if random.uniform() < 0.5 else 0.0)
                aside = float(random.choice([-1.0, 1.0]) * random.uniform(1.6, 5.0))
            elif role < 0.80:
                kind, v, turn = PEDESTRIAN, 0.0, random.uniform(-math.pi, math.pi)
                aside = float(random.choice([-1.0, 1.0]) * random.uniform(1.3, 8.0))
            elif role < 0.92:
                kind, v = CYCLIST, random.uniform(2.5, 5.0)
                turn = random.normal(0.0, 0.08) + (math.pi if random.uniform() < 0.5 else 0.0)
                aside = float(random.choice([-1.0, 1.0]) * random.uniform(1.8, 5.0))
            else:
                kind, v = VEHICLE, float(random.choice([0.0, random.uniform(2.0, 6.0)]))
                turn = math.pi if random.uniform() < 0.7 else 0.0
                aside = float(random.uniform(3.2, 6.0))
            where = np.array([[x - aside * math.sin(yaw), y + aside * math.cos(yaw)]])
            free_m = float(outline_distance(pose, where)[0]) - 0.5 * max(_SIZES[kind])
            if free_m < 0.3 and not (inside and not kinds):
                continue
            kinds.append(kind)
            poses.append((*where[0], yaw + turn))
            speeds.append(max(float(v), 0.0))
        if inside:
            poses[0] = (pose.x_m + math.cos(pose.yaw_rad), pose.y_m + math.sin(pose.yaw_rad), 0.0)
            kinds[0], speeds[0] = PEDESTRIAN, 0.0
        sizes = np.array([_SIZES[kind] for kind in kinds])
        return np.array(kinds, dtype=np.int64), np.array(poses), np.array(speeds), sizes


def _leave_way_out(scene: Scene) -> None:
    """Remove road users that even the hardest braking would hit: such a scene cannot have come about."""
    params = MotionParams()
    corridor = scene.corridor()
    n = len(corridor.s_m)
    wide = np.full(n, 50.0)
    v0, decel = scene.start.speed_mps, 0.8 * params.limits.hard_decel_mps2
    t = 0.1 * np.arange(round(v0 / decel / 0.1) + 2)
    moving = np.minimum(t, v0 / decel)
    u = v0 * moving - 0.5 * decel * moving**2
    kappa = scene.start.curvature_1pm
    pose = scene.start.pose_map
    yaw = pose.yaw_rad + kappa * u
    chord = u * np.sinc(0.5 * kappa * u / math.pi)
    x = pose.x_m + chord * np.cos(pose.yaw_rad + 0.5 * kappa * u)
    y = pose.y_m + chord * np.sin(pose.yaw_rad + 0.5 * kappa * u)
    v = v0 - decel * moving
    rows = np.column_stack([t, x, y, yaw, np.full(len(t), kappa), v, 0.0 * t, scene.s_m + u])
    kept = np.ones(len(scene.kinds), bool)
    for i in range(len(scene.kinds)):
        one = np.arange(len(scene.kinds)) == i
        agents = scene.agents(np.zeros((len(one), 33)), np.zeros(len(one), np.int64))
        alone = Agents(
            agents.ids[one],
            agents.kinds[one],
            agents.times_s,
            agents.poses_map[one],
            agents.sizes_m[one],
            agents.inflation_m[one],
            agents.pass_rule[one],
        )
        request = MotionRequest(corridor, scene.start, 0.0 * wide, -wide, wide, wide, agents=alone)
        kept[i] = "agent" not in violations(rows, request, params.vehicle, params.limits, emergency=True)
    for i in np.flatnonzero(~kept):
        # Out of the way, but still one of the fifty.
        scene.poses_map[i, 0] += 30.0


def _on_road(road: Corridor, s_m: float) -> tuple[float, float, float]:
    s_m = min(max(s_m, float(road.s_m[0])), float(road.s_m[-1]))
    x, y = (float(np.interp(s_m, road.s_m, road.points_map[:, i])) for i in range(2))
    return x, y, float(np.interp(s_m, road.s_m, road.yaw_rad))


def _roadside(road: Corridor, s_m: float, pose: Pose2, random: Generator) -> Array:
    """(m, 2) lidar-like points: hedges along both sides with gaps, and now and then a thing on the road."""
    points = []
    for at in np.arange(s_m - 6.0, s_m + 50.0, 0.4):
        x, y, yaw = _on_road(road, float(at))
        for side in (-1.0, 1.0):
            if random.uniform() < 0.7:
                aside = side * random.uniform(2.6, 4.5)
                points.append((x - aside * math.sin(yaw), y + aside * math.cos(yaw)))
    if random.uniform() < 0.4:
        x, y, yaw = _on_road(road, s_m + float(random.uniform(12.0, 40.0)))
        aside = float(random.choice([-1.0, 1.0]) * random.uniform(0.5, 2.0))
        points += [(x - aside * math.sin(yaw) + dx, y + aside * math.cos(yaw)) for dx in (0.0, 0.25, 0.5)]
    static = np.array(points)
    return static[outline_distance(pose, static) > 0.5]


def _bends(random: Generator) -> Corridor:
    """A synthetic road: straights and arcs of 9 m radius and more, 2.2 m of room on each side."""
    kappa = np.concatenate(
        [
            np.full(int(random.integers(20, 60)), float(k))
            for k in (0.0, random.uniform(-0.1, 0.1), 0.0, random.uniform(-0.1, 0.1), 0.0, 0.0)
        ]
    )
    kappa = np.convolve(kappa, np.full(9, 1.0 / 9.0), mode="same")
    s = 0.5 * np.arange(len(kappa))
    yaw = np.concatenate([[0.0], np.cumsum(0.25 * (kappa[1:] + kappa[:-1]))])
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    x = np.concatenate([[0.0], np.cumsum(0.5 * np.cos(middle))])
    y = np.concatenate([[0.0], np.cumsum(0.5 * np.sin(middle))])
    one = np.ones(len(s))
    return Corridor(
        s, np.column_stack([x, y]), yaw, kappa, 4.17 * one, 2.2 * one, 2.2 * one, np.zeros(len(s), np.int64)
    )
