"""Kernels on particles: motion, weights, resampling. A particle is a pose x_m, y_m, yaw_rad of the laser."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, wrap_angle
from vehicle_agent.localization.monte_carlo.likelihood_field import Float32Array
from vehicle_agent.localization.monte_carlo.random_numbers import GeneratorState, normal, uniform

_CLIMB_STEPS_MAX = 60


@njit(cache=True)
def move(
    poses: Array,
    way: Array,
    std_m: float,
    std_rad: float,
    slip_ratio: float,
    slip_m: float,
    slip_rad: float,
    random: GeneratorState,
) -> None:
    """Moves each of (n, 3) poses by the way (3,) in its own frame, with noise of these standard deviations.

    slip_ratio  share of the poses whose noise is slip_m, slip_rad instead: for wheels that slip
    """
    for i in range(poses.shape[0]):
        is_slip = uniform(random) < slip_ratio
        noise_m = slip_m if is_slip else std_m
        noise_rad = slip_rad if is_slip else std_rad
        forward = way[0] + noise_m * normal(random)
        left = way[1] + noise_m * normal(random)
        cos, sin = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        poses[i, 0] += cos * forward - sin * left
        poses[i, 1] += sin * forward + cos * left
        poses[i, 2] = wrap_angle(poses[i, 2] + way[2] + noise_rad * normal(random))


@njit(cache=True)
def mean_over_beams(
    poses: Array,
    points: Array,
    field: Float32Array,
    outside: float,
    origin_x_m: float,
    origin_y_m: float,
    cell_m: float,
) -> Array:
    """(n,) the mean of the field's values where the beams' ends (m, 2) lie from each pose (n, 3)."""
    n, m = poses.shape[0], points.shape[0]
    rows, columns = field.shape
    out = np.empty(n)
    for i in range(n):
        cos, sin = math.cos(poses[i, 2]) / cell_m, math.sin(poses[i, 2]) / cell_m
        x, y = (poses[i, 0] - origin_x_m) / cell_m, (poses[i, 1] - origin_y_m) / cell_m
        total = 0.0
        for j in range(m):
            column = math.floor(x + cos * points[j, 0] - sin * points[j, 1])
            row = math.floor(y + sin * points[j, 0] + cos * points[j, 1])
            if 0 <= row < rows and 0 <= column < columns:
                total += field[row, column]
            else:
                total += outside
        out[i] = total / m
    return out


@njit(cache=True)
def climb(
    poses: Array,
    points: Array,
    field: Float32Array,
    outside: float,
    origin_x_m: float,
    origin_y_m: float,
    cell_m: float,
    step_m: float,
    step_rad: float,
) -> None:
    """Moves each of (n, 3) poses uphill in the mean over the beams, by steps that halve until they are a
    sixteenth."""
    tried = np.empty((6, 3))
    for i in range(poses.shape[0]):
        best = mean_over_beams(poses[i : i + 1], points, field, outside, origin_x_m, origin_y_m, cell_m)[0]
        share = 1.0
        for _ in range(_CLIMB_STEPS_MAX):
            for k in range(6):
                tried[k] = poses[i]
                sign = 1.0 if k % 2 else -1.0
                tried[k, k // 2] += sign * share * (step_rad if k // 2 == 2 else step_m)
            values = mean_over_beams(tried, points, field, outside, origin_x_m, origin_y_m, cell_m)
            highest = np.argmax(values)
            if values[highest] > best:
                best = values[highest]
                poses[i] = tried[highest]
            else:
                share *= 0.5
                if share < 1.0 / 16.0:
                    break
        poses[i, 2] = wrap_angle(poses[i, 2])


@njit(cache=True)
def kld_resampled(
    poses: Array,
    weights: Array,
    bin_m: float,
    bin_rad: float,
    error: float,
    quantile: float,
    least: int,
    most: int,
    random: GeneratorState,
) -> Array:
    """(k, 3) poses drawn by weight, as many as KLD-sampling asks for (Fox 2003, table 3), least <= k <= most.

    error, quantile  the divergence from the true density stays below `error` with the probability of the
                     normal distribution's `quantile`
    """
    sums = np.cumsum(weights)
    table = np.full(4 * most, -1, dtype=np.int64)
    out = np.empty((most, 3))
    bins, needed, k = 0, float(least), 0
    headings = np.int64(math.ceil(2.0 * math.pi / bin_rad))
    while k < most and k < max(needed, least):
        i = min(np.searchsorted(sums, uniform(random) * sums[-1], side="right"), poses.shape[0] - 1)
        out[k] = poses[i]
        k += 1
        column = np.int64(math.floor(poses[i, 0] / bin_m)) + 1_000_000
        row = np.int64(math.floor(poses[i, 1] / bin_m)) + 1_000_000
        heading = np.int64(math.floor((poses[i, 2] + math.pi) / bin_rad))
        key = (row * 2_000_001 + column) * headings + heading
        slot = (key * 2654435761) % table.shape[0]
        while table[slot] != -1 and table[slot] != key:
            slot = (slot + 1) % table.shape[0]
        if table[slot] == -1:
            table[slot] = key
            bins += 1
            if bins > 1:
                # Wilson and Hilferty's approximation of the chi-square quantile.
                part = 2.0 / (9.0 * (bins - 1))
                needed = (bins - 1) / (2.0 * error) * (1.0 - part + math.sqrt(part) * quantile) ** 3
    return out[:k].copy()


@njit(cache=True)
def uniform_poses(free: Array, count: int, cell_m: float, random: GeneratorState) -> Array:
    """(count, 3) poses anywhere in the free cells, whose middles are (k, 2)."""
    out = np.empty((count, 3))
    for i in range(count):
        cell = int(uniform(random) * free.shape[0])
        out[i, 0] = free[cell, 0] + (uniform(random) - 0.5) * cell_m
        out[i, 1] = free[cell, 1] + (uniform(random) - 0.5) * cell_m
        out[i, 2] = (2.0 * uniform(random) - 1.0) * math.pi
    return out
