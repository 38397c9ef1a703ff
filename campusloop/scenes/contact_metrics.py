"""Contacts and clearances of a driven scene, by ground truth.

A contact begins when a person's disc or another vehicle's outline overlaps the vehicle's outline. It is a
*front* contact if the vehicle moves faster than 0.3 m/s and the overlap begins at its front: the vehicle has
hit someone. All others, at its sides or while it stands, are counted separately.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray
from simulator.traffic.actors import Bodies
from vehicle_agent.config import Body

MOVING_MPS = 0.3
# An overlap begins at the front if its nearest point is at most this far behind the bumper.
FRONT_DEPTH_M = 0.3


@dataclass(frozen=True, slots=True)
class ContactMetrics:
    """front_contacts and other_contacts: (t_s, id, speed_mps).

    clearance_m: the least to a person's disc or another vehicle's outline while the vehicle moved; inf if
    there was none near
    """

    front_contacts: tuple[tuple[float, int, float], ...]
    other_contacts: tuple[tuple[float, int, float], ...]
    clearance_m: float


def contact_metrics(rows: Array, agents: list[Bodies], body: Body) -> ContactMetrics:
    """The metrics of a drive. rows (n, 7): `trace.VEHICLE_COLUMNS`; agents: at the same times."""
    front: list[tuple[float, int, float]] = []
    other: list[tuple[float, int, float]] = []
    touching: set[int] = set()
    least_m = math.inf
    half_m = 0.5 * body.width_m
    outline = (body.rear_overhang_m, body.front_overhang_m, half_m)
    for row, bodies in zip(rows, agents, strict=True):
        if not len(bodies.numbers):
            touching = set()
            continue
        t_s, x_m, y_m, yaw_rad, speed_mps = row[:5]
        clearance, ahead = clearances(
            x_m, y_m, yaw_rad, *outline, bodies.poses_map, bodies.sizes_m, bodies.people
        )
        moving = abs(speed_mps) > MOVING_MPS
        if moving:
            least_m = min(least_m, float(clearance.min()))
        now = set(bodies.numbers[clearance < 0.0].tolist())
        for k in np.flatnonzero(clearance < 0.0):
            number = int(bodies.numbers[k])
            if number in touching:
                continue
            is_front = moving and ahead[k] > body.front_overhang_m - FRONT_DEPTH_M
            (front if is_front else other).append((float(t_s), number, float(speed_mps)))
        touching = now
    return ContactMetrics(tuple(front), tuple(other), least_m)


@njit(cache=True)
def clearances(
    x: float,
    y: float,
    yaw: float,
    rear: float,
    front: float,
    half: float,
    poses: Array,
    sizes: Array,
    people: BoolArray,
) -> tuple[Array, Array]:
    """((n,), (n,)): clearance to each agent, negative for an overlap, and how far ahead of the rear axle its
    nearest point lies. People are discs, others boxes (their clearance is that of sampled outlines)."""
    n = poses.shape[0]
    out, ahead = np.full(n, np.inf), np.zeros(n)
    cos, sin = math.cos(yaw), math.sin(yaw)
    for i in range(n):
        dx, dy = poses[i, 0] - x, poses[i, 1] - y
        if math.hypot(dx, dy) > 30.0:
            continue
        u, v = cos * dx + sin * dy, -sin * dx + cos * dy
        if people[i]:
            out[i] = _outside(u, v, rear, front, half) - 0.5 * sizes[i, 0]
            ahead[i] = min(max(u, -rear), front)
            if -rear < u < front and abs(v) > half:
                # Alongside the body: a contact at the side, however near to the bumper.
                ahead[i] = min(ahead[i], u)
            continue
        out[i], ahead[i] = _box(u, v, poses[i, 2] - yaw, sizes[i, 0], sizes[i, 1], rear, front, half)
    return out, ahead


@njit(cache=True)
def _outside(u: float, v: float, rear: float, front: float, half: float) -> float:
    """Distance of a point (body frame) from the outline; negative inside."""
    du, dv = max(u - front, -rear - u), abs(v) - half
    if du > 0.0 and dv > 0.0:
        return math.hypot(du, dv)
    return max(du, dv)


@njit(cache=True)
def _box(
    u: float, v: float, turned: float, length: float, width: float, rear: float, front: float, half: float
) -> tuple[float, float]:
    """Least signed distance between two outlines, sampled every 0.2 m, and its position along ours."""
    cos, sin = math.cos(turned), math.sin(turned)
    best, where = np.inf, 0.0
    steps_u, steps_v = math.ceil(length / 0.2) + 1, math.ceil(width / 0.2) + 1
    for a in range(steps_u):
        for b in range(steps_v):
            if 0 < a < steps_u - 1 and 0 < b < steps_v - 1:
                continue
            p = -0.5 * length + length * a / (steps_u - 1)
            q = -0.5 * width + width * b / (steps_v - 1)
            x, y = u + cos * p - sin * q, v + sin * p + cos * q
            distance = _outside(x, y, rear, front, half)
            if distance < best:
                best, where = distance, min(max(x, -rear), front)
    # Our corners may stand inside the other while none of its edge points is inside us.
    for x0 in (-rear, front):
        for y0 in (-half, half):
            dx, dy = x0 - u, y0 - v
            p, q = cos * dx + sin * dy, -sin * dx + cos * dy
            depth = max(abs(p) - 0.5 * length, abs(q) - 0.5 * width)
            if depth < 0.0 and depth < best:
                best, where = depth, x0
    return best, where
