"""Road users around a vehicle, drawn for one scan: where they stand, ride and drive, and how fast."""

import numpy as np
from numpy.typing import NDArray

from campusloop.scenes.detector_scenes.campuses import CampusScene
from contract.geometry import Array
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE

REACH_M = 46.0
# A crowd stands on every so many scenes.
_CROWD_RATIO = 0.12
# Bodies nearer than the sum of their half lengths and this overlap; people may stand closer.
_APART_M, _PEOPLE_APART_M = 0.3, 0.55
# The own vehicle's place ahead of its rear axle, and its length and width.
_OWN_MIDDLE_M, _OWN_M = 1.3, np.array([4.6, 2.0])
_SPEEDS_MPS = {PEDESTRIAN: 1.3, CYCLIST: 3.5, VEHICLE: 4.0}
_STANDING_RATIO = {PEDESTRIAN: 0.35, CYCLIST: 0.15, VEHICLE: 0.4, OTHER: 1.0}


def draw_kinds(rng: np.random.Generator, with_others: bool) -> NDArray[np.int64]:
    """(n,) kinds of one scene's road users; with things that are none of them."""
    people = rng.integers(25, 60) if rng.random() < _CROWD_RATIO else rng.integers(2, 16)
    counts = ((VEHICLE, rng.integers(1, 6)), (CYCLIST, rng.integers(1, 7)), (PEDESTRIAN, people))
    kinds = [np.full(count, kind, dtype=np.int64) for kind, count in counts]
    if with_others:
        kinds.append(np.full(rng.integers(2, 16), OTHER, dtype=np.int64))
    return np.concatenate(kinds)


def draw_bodies(
    kinds: NDArray[np.int64], sizes_m: Array, campus: CampusScene, around: Array, rng: np.random.Generator
) -> tuple[Bodies, NDArray[np.int64]]:
    """(bodies, rows (k,) of kinds that found a free place) around a pose (3,), none of which overlap.

    sizes_m  (n, 3) length, width, height
    """
    near = np.hypot(*(campus.lanes[:, :2] - around[:2]).T) < REACH_M
    lanes = campus.lanes[near]
    parked = campus.static.parked
    parked = parked[np.hypot(*(parked[:, :2] - around[:2]).T) < REACH_M + 8.0]
    # Outlines as three discs along their length, (m, 3) x, y, radius; the own vehicle is the first.
    middle = around[:2] + _OWN_MIDDLE_M * np.array([np.cos(around[2]), np.sin(around[2])])
    taken = [_discs(np.array([*middle, around[2]]), _OWN_M)]
    taken += [_discs(row[:3], row[3:5]) for row in parked]
    rows, poses = [], []
    crowd = around[:2] + rng.uniform(-20.0, 20.0, 2)
    for row, kind in enumerate(kinds):
        for _ in range(8):
            pose = _draw_pose(int(kind), lanes, crowd if len(kinds) > 30 else None, around, rng)
            discs = _discs(pose, sizes_m[row, :2])
            apart_m = _PEOPLE_APART_M - 0.5 if kind == PEDESTRIAN else _APART_M
            if _is_free(discs, np.concatenate(taken), apart_m):
                taken.append(discs)
                rows.append(row)
                poses.append(pose)
                break
    chosen = np.array(rows, dtype=np.int64)
    placed = np.array(poses).reshape(-1, 3)
    speeds = np.array([_draw_speed(int(kind), rng) for kind in kinds[chosen]])
    velocities = speeds[:, None] * np.column_stack((np.cos(placed[:, 2]), np.sin(placed[:, 2])))
    numbers = np.arange(len(chosen), dtype=np.int64)
    return Bodies(numbers, kinds[chosen], placed, velocities, sizes_m[chosen, :2]), chosen


def _draw_pose(
    kind: int, lanes: Array, crowd: Array | None, around: Array, rng: np.random.Generator
) -> Array:
    """(3,) x, y, yaw: vehicles on lanes, the others also beside them."""
    turned = rng.uniform(-np.pi, np.pi)
    if crowd is not None and kind == PEDESTRIAN and rng.random() < 0.7:
        x, y = crowd + rng.normal(0.0, 5.0, 2)
        return np.array([x, y, turned])
    on_lane = rng.random() < {VEHICLE: 0.9, CYCLIST: 0.7, PEDESTRIAN: 0.7}.get(kind, 0.6)
    if on_lane and len(lanes):
        lane = lanes[rng.integers(len(lanes))]
        side_m = rng.normal(0.0, 0.5) if kind == VEHICLE else rng.normal(0.0, 3.0)
        along = lane[2] + rng.normal(0.0, 0.1) + np.pi * (rng.random() < 0.3)
        yaw = turned if kind in (PEDESTRIAN, OTHER) and rng.random() < 0.6 else along
        return np.array([lane[0] - side_m * np.sin(lane[2]), lane[1] + side_m * np.cos(lane[2]), yaw])
    # More of them near than a uniform density gives.
    reach_m, bearing = rng.uniform(2.5, REACH_M), rng.uniform(-np.pi, np.pi)
    return np.array([around[0] + reach_m * np.cos(bearing), around[1] + reach_m * np.sin(bearing), turned])


def _draw_speed(kind: int, rng: np.random.Generator) -> float:
    if rng.random() < _STANDING_RATIO[kind]:
        return 0.0
    usual = _SPEEDS_MPS[kind]
    return float(np.clip(rng.normal(usual, 0.4 * usual), 0.2, 2.2 * usual))


def _discs(pose: Array, size_m: Array) -> Array:
    radius = 0.5 * float(size_m[1])
    reach = max(0.0, 0.5 * float(size_m[0]) - radius)
    along = np.array([-reach, 0.0, reach])
    x, y = pose[0] + along * np.cos(pose[2]), pose[1] + along * np.sin(pose[2])
    return np.column_stack((x, y, np.full(3, radius)))


def _is_free(discs: Array, taken: Array, apart_m: float) -> bool:
    gaps = np.hypot(discs[:, None, 0] - taken[None, :, 0], discs[:, None, 1] - taken[None, :, 1])
    return bool((gaps - discs[:, None, 2] - taken[None, :, 2] > apart_m).all())
