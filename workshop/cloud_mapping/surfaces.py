"""The map's surface elements: points by voxels, less those that other beams went through."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, IntArray
from contract.point_map.tiles import Surfels
from vehicle_agent.localization.odometry.voxel_map import Array32, Counts, packed, slot_of

_EMPTY = -1


class SurfaceParams(msgspec.Struct, frozen=True):
    """What becomes an element, and what has moved.

    voxel_m              edge of the voxels, one element each
    points_min, seen_min points and keyframes that an element needs
    across_m, along_m    a surface's points spread less than this across it, and more than this along it
    through_m            a beam that passes an element nearer than this goes through it
    short_m              so much of a beam before its end says nothing
    reach_m              of beams that are followed
    beams_every          one beam of so many is followed
    through_ratio        an element is removed if so many times the keyframes that saw it saw through it
    through_min          and at least so many did
    """

    voxel_m: float = 0.5
    points_min: int = 4
    seen_min: int = 2
    across_m: float = 0.07
    along_m: float = 0.08
    through_m: float = 0.15
    short_m: float = 0.7
    reach_m: float = 30.0
    beams_every: int = 3
    through_ratio: float = 3.0
    through_min: int = 3


@dataclass(slots=True, eq=False)
class _Table:
    """Voxels by hash, c places.

    sums  (c, 9) of differences from the voxel's middle, and of their products
    last  (c,) the keyframe that was counted last in `seen`
    """

    keys: IntArray
    sums: Array32
    counts: Counts
    seen: Counts
    last: Counts
    used: int = 0


def surfels_of(
    clouds: Sequence[Array32], poses: Array, params: SurfaceParams, advance: Callable[[int], None]
) -> tuple[Surfels, int]:
    """(the elements, how many were removed because beams went through); poses (k, 4, 4) of the clouds."""
    table = _empty(1 << 16)
    for number, cloud in enumerate(clouds):
        if table.used + len(cloud) > len(table.keys) // 2:
            table = _grown(table, table.used + len(cloud))
        table.used += _add(
            cloud,
            poses[number],
            number,
            params.voxel_m,
            table.keys,
            table.sums,
            table.counts,
            table.seen,
            table.last,
        )
        advance(1)
    taken = np.flatnonzero((table.counts >= params.points_min) & (table.seen >= params.seen_min))
    means, normals, std_m = _elements(table, taken, params)
    # Elements by place in the table, for the beams.
    number_at = np.full(len(table.keys), _EMPTY, dtype=np.int64)
    number_at[taken] = np.arange(len(taken))
    through = np.zeros(len(taken), dtype=np.int32)
    last = np.full(len(taken), _EMPTY, dtype=np.int32)
    for number, cloud in enumerate(clouds):
        _follow(
            cloud, poses[number], number, params.voxel_m, table.keys, number_at, means, normals,
            params.through_m, params.short_m, params.reach_m, params.beams_every, through, last,
        )  # fmt: skip
        advance(1)
    seen = table.seen[taken]
    moved = (through >= params.through_min) & (through > params.through_ratio * seen)
    kept: BoolArray = ~moved
    found = Surfels(means[kept], normals[kept], std_m[kept], seen[kept].astype(np.float64))
    return found, int(moved.sum())


def seen_through(
    surfels: Surfels, clouds: Sequence[Array32], poses: Array, params: SurfaceParams
) -> IntArray:
    """(n,) keyframes whose beams went through each element of another map; poses (k, 4, 4) of the clouds.

    Of two elements in one voxel the last one is looked at.
    """
    keys = np.full(1 << max(4, math.ceil(math.log2(4 * max(1, len(surfels))))), _EMPTY, dtype=np.int64)
    number_at = np.full(len(keys), _EMPTY, dtype=np.int64)
    voxels = np.floor(surfels.means / params.voxel_m).astype(np.int64)
    wanted = np.array([packed(x, y, z) for x, y, z in voxels.tolist()], dtype=np.int64)
    number_at[_taken(wanted, keys)] = np.arange(len(surfels))
    through = np.zeros(len(surfels), dtype=np.int32)
    last = np.full(len(surfels), _EMPTY, dtype=np.int32)
    for number, cloud in enumerate(clouds):
        _follow(
            cloud, poses[number], number, params.voxel_m, keys, number_at, surfels.means, surfels.normals,
            params.through_m, params.short_m, params.reach_m, params.beams_every, through, last,
        )  # fmt: skip
    counted: IntArray = through.astype(np.int64)
    return counted


def _empty(capacity: int) -> _Table:
    return _Table(
        np.full(capacity, _EMPTY, dtype=np.int64),
        np.zeros((capacity, 9), dtype=np.float32),
        np.zeros(capacity, dtype=np.int32),
        np.zeros(capacity, dtype=np.int32),
        np.full(capacity, _EMPTY, dtype=np.int32),
    )


def _grown(table: _Table, wanted: int) -> _Table:
    capacity = len(table.keys)
    while capacity < 4 * wanted:
        capacity *= 2
    fresh = _empty(capacity)
    kept = np.flatnonzero(table.keys != _EMPTY)
    slots = _taken(table.keys[kept], fresh.keys)
    fresh.sums[slots], fresh.counts[slots] = table.sums[kept], table.counts[kept]
    fresh.seen[slots], fresh.last[slots] = table.seen[kept], table.last[kept]
    fresh.used = len(kept)
    return fresh


@njit(cache=True)
def _taken(wanted: IntArray, keys: IntArray) -> IntArray:
    slots = np.empty(wanted.shape[0], dtype=np.int64)
    for i in range(wanted.shape[0]):
        slots[i] = slot_of(keys, wanted[i])
        keys[slots[i]] = wanted[i]
    return slots


@njit(cache=True)
def _add(
    cloud: Array32, pose: Array, number: int, voxel_m: float, keys: IntArray, sums: Array32, counts: Counts,
    seen: Counts, last: Counts,
) -> int:  # fmt: skip
    fresh = 0
    for i in range(cloud.shape[0]):
        px, py, pz = float(cloud[i, 0]), float(cloud[i, 1]), float(cloud[i, 2])
        x = pose[0, 0] * px + pose[0, 1] * py + pose[0, 2] * pz + pose[0, 3]
        y = pose[1, 0] * px + pose[1, 1] * py + pose[1, 2] * pz + pose[1, 3]
        z = pose[2, 0] * px + pose[2, 1] * py + pose[2, 2] * pz + pose[2, 3]
        vx, vy, vz = math.floor(x / voxel_m), math.floor(y / voxel_m), math.floor(z / voxel_m)
        key = packed(vx, vy, vz)
        at = slot_of(keys, key)
        if keys[at] == _EMPTY:
            keys[at] = key
            fresh += 1
        dx, dy, dz = x - (vx + 0.5) * voxel_m, y - (vy + 0.5) * voxel_m, z - (vz + 0.5) * voxel_m
        row = sums[at]
        row[0] += dx
        row[1] += dy
        row[2] += dz
        row[3] += dx * dx
        row[4] += dx * dy
        row[5] += dx * dz
        row[6] += dy * dy
        row[7] += dy * dz
        row[8] += dz * dz
        counts[at] += 1
        if last[at] != number:
            last[at] = number
            seen[at] += 1
    return fresh


def _elements(table: _Table, taken: IntArray, params: SurfaceParams) -> tuple[Array, Array, Array]:
    """(means, normals, deviations) of the voxels at these places of the table."""
    sums = table.sums[taken].astype(np.float64) / table.counts[taken, None]
    keys = table.keys[taken]
    half = 1 << 20
    voxel = np.column_stack((keys >> 42, (keys >> 21) & (2 * half - 1), keys & (2 * half - 1))) - half
    offset = sums[:, :3]
    means = (voxel + 0.5) * params.voxel_m + offset
    spread = sums[:, [3, 4, 5, 4, 6, 7, 5, 7, 8]].reshape(-1, 3, 3) - offset[:, :, None] * offset[:, None, :]
    values, axes = np.linalg.eigh(spread) if len(spread) else (np.zeros((0, 3)), np.zeros((0, 3, 3)))
    across, along = np.sqrt(np.maximum(values[:, 0], 0.0)), np.sqrt(np.maximum(values[:, 1], 0.0))
    flat = (across <= params.across_m) & (along >= params.along_m)
    normals = np.where(flat[:, None], axes[:, :, 0], 0.0)
    std_m = np.where(flat, across, np.sqrt(np.maximum(values.sum(axis=1), 0.0)))
    return means, normals, std_m


@njit(cache=True)
def _follow(
    cloud: Array32, pose: Array, number: int, voxel_m: float, keys: IntArray, number_at: IntArray,
    means: Array, normals: Array, through_m: float, short_m: float, reach_m: float, every: int,
    through: Counts, last: Counts,
) -> None:  # fmt: skip
    """Counts, once for each keyframe, the elements that beams of the cloud go through."""
    ox, oy, oz = pose[0, 3], pose[1, 3], pose[2, 3]
    step_m = 0.5 * voxel_m
    for i in range(number % every, cloud.shape[0], every):
        px, py, pz = float(cloud[i, 0]), float(cloud[i, 1]), float(cloud[i, 2])
        length = math.sqrt(px * px + py * py + pz * pz)
        ux = (pose[0, 0] * px + pose[0, 1] * py + pose[0, 2] * pz) / length
        uy = (pose[1, 0] * px + pose[1, 1] * py + pose[1, 2] * pz) / length
        uz = (pose[2, 0] * px + pose[2, 1] * py + pose[2, 2] * pz) / length
        end = min(reach_m, length - short_m)
        before = packed(0, 0, 0)
        s = 1.0
        while s < end:
            x, y, z = ox + s * ux, oy + s * uy, oz + s * uz
            s += step_m
            key = packed(math.floor(x / voxel_m), math.floor(y / voxel_m), math.floor(z / voxel_m))
            if key == before:
                continue
            before = key
            at = slot_of(keys, key)
            if keys[at] == _EMPTY or number_at[at] < 0:
                continue
            e = number_at[at]
            if last[e] == number:
                continue
            dx, dy, dz = means[e, 0] - ox, means[e, 1] - oy, means[e, 2] - oz
            along = dx * ux + dy * uy + dz * uz
            if along > end:
                continue
            nx, ny, nz = normals[e, 0], normals[e, 1], normals[e, 2]
            slant = nx * ux + ny * uy + nz * uz
            if nx != 0.0 or ny != 0.0 or nz != 0.0:
                # Beams along a surface pass it; they go through where they cross it.
                if abs(slant) < 0.15:
                    continue
                t = (nx * dx + ny * dy + nz * dz) / slant
                if t > end:
                    continue
                cx, cy, cz = t * ux - dx, t * uy - dy, t * uz - dz
                if cx * cx + cy * cy + cz * cz > 4.0 * through_m * through_m:
                    continue
            else:
                cx, cy, cz = along * ux - dx, along * uy - dy, along * uz - dz
                if cx * cx + cy * cy + cz * cz > through_m * through_m:
                    continue
            last[e] = number
            through[e] += 1
