"""A long way from stop to stop over a map, and the motion of a vehicle that is exactly on it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from contract.geometry import Array, Pose2, resample, wrap_angle
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_line
from simulator.vehicle.plant import PlantView

SPACING_M = 0.25
# Lanes of maps bend in corners; vehicles do not.
SMOOTHED_M = 4.0
STEP_S = 0.02
DWELL_S = 8.0
ACCEL_MPS2 = 0.8
LATERAL_MPS2 = 0.8
CREEP_MPS = 0.15


@dataclass(frozen=True, slots=True)
class Way:
    """Through stops: points (n, 2) every 0.25 m, course (n,) unwrapped, curvature (n,), speed (n,).

    stops_m (k,): where it stands, along the way
    """

    points: Array
    course_rad: Array
    curvature_1pm: Array
    speed_mps: Array
    stops_m: Array

    @property
    def length_m(self) -> float:
        return SPACING_M * (len(self.points) - 1)


def campus_way(road_map: RoadMap, km: float, speed_mps: float, rng: np.random.Generator) -> Way:
    """From stop to stop, drawn at random, for so many km."""
    network, stops = RoadNetwork(road_map), road_map.stops
    here, pieces, stops_m, length_m = stops[int(rng.integers(len(stops)))], [], [0.0], 0.0
    while length_m < 1e3 * km:
        there = stops[int(rng.integers(len(stops)))]
        route = find_route(network, here.lane_id, here.s_m, there.lane_id, there.s_m)
        if route is None or route.length_m < 50.0:
            continue
        pieces.append(route_line(network, route).points)
        length_m += route.length_m
        stops_m.append(length_m)
        here = there
    return _smoothed(np.concatenate(pieces), np.array(stops_m), speed_mps)


def beside(way: Way, way_m: float, left_m: float, *, back: bool) -> Way:
    """The first metres of a way, driven so far to the left of it; `back`: from its end to its beginning."""
    count = round(way_m / SPACING_M) + 1
    points, course = way.points[:count], way.course_rad[:count]
    shifted = points + left_m * np.column_stack((-np.sin(course), np.cos(course)))
    # Inside a narrow turn the shifted line runs backwards.
    steps = np.diff(shifted, axis=0)
    forward = (steps * np.diff(points, axis=0)).sum(axis=1) > 0.0
    shifted = shifted[np.concatenate(([True], forward))]
    stops_m = way.stops_m[way.stops_m < way_m]
    if back:
        shifted, stops_m = shifted[::-1], way_m - stops_m[::-1]
    length_m = float(np.hypot(*np.diff(shifted, axis=0).T).sum())
    return _smoothed(shifted, stops_m * length_m / way_m, float(way.speed_mps.max()))


def _smoothed(points: Array, stops_m: Array, speed_mps: float) -> Way:
    apart = np.hypot(*np.diff(points, axis=0).T) > 1e-6
    points = points[np.concatenate(([True], apart))]
    before_m = float(np.hypot(*np.diff(points, axis=0).T).sum())
    window = max(1, round(SMOOTHED_M / SPACING_M))
    fine = resample(points, SPACING_M)
    for _ in range(2):
        fine = uniform_filter1d(fine, window, axis=0, mode="nearest")
    fine = resample(fine, SPACING_M)
    steps = np.diff(fine, axis=0)
    course = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    course = np.append(course, course[-1])
    curvature = uniform_filter1d(np.gradient(course, SPACING_M), window, mode="nearest")
    speed = np.minimum(speed_mps, np.sqrt(LATERAL_MPS2 / np.maximum(np.abs(curvature), 1e-6)))
    # Corners that were cut made the way shorter.
    stops_m = stops_m * SPACING_M * (len(fine) - 1) / before_m
    speed[np.minimum(np.round(stops_m / SPACING_M).astype(np.int64), len(speed) - 1)] = 0.0
    for order, back in ((range(1, len(speed)), -1), (range(len(speed) - 2, -1, -1), 1)):
        for i in order:
            speed[i] = min(speed[i], math.sqrt(speed[i + back] ** 2 + 2.0 * ACCEL_MPS2 * SPACING_M))
    return Way(fine, course, curvature, speed, stops_m)


def truths(way: Way, slip_s2pm: float) -> Iterator[PlantView]:
    """The vehicle every 20 ms; at each stop it stands for 8 s. slip_s2pm: of its rear axle."""
    grid, s = SPACING_M * np.arange(len(way.points)), 0.0
    stops_m = list(way.stops_m)
    while s < way.length_m:
        v = max(CREEP_MPS, float(np.interp(s, grid, way.speed_mps)))
        kappa, course = (float(np.interp(s, grid, row)) for row in (way.curvature_1pm, way.course_rad))
        x, y = (float(np.interp(s, grid, way.points[:, i])) for i in (0, 1))
        pose = Pose2(x, y, wrap_angle(course + slip_s2pm * v * v * kappa))
        if stops_m and s >= stops_m[0]:
            stops_m.pop(0)
            for _ in range(round(DWELL_S / STEP_S)):
                yield PlantView(pose, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, s, 1.0)
        yield PlantView(pose, v, 0.0, 0.0, 0.0, 0.0, v * kappa, s, 1.0)
        s += v * STEP_S
