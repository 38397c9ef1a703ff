"""People as a camera sees them: bodies that walk, in clothes of several colours."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.scene.mesh import box, quads

# Which part of a figure a triangle belongs to; an index into a person's colours.
SKIN, HAIR, TOP, BOTTOM, SHOES, BAG = range(6)
# Takes the triangles of a solid, and the part that they are.
AddSolid = Callable[[Array, int], None]
Points = Array | tuple[float, float, float]
_SWING_RAD = 0.38
_PHASES = 16
_SIDES = 10


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """One pose of a person of 1.75 m who stands on z = 0 and looks along x.

    triangles  (n, 3, 3); parts (n,) of SKIN to BAG
    """

    triangles: NDArray[np.float32]
    parts: NDArray[np.int64]


class Wardrobe:
    """The figures of all phases of a step and all styles of clothes, made once.

    styles: 0 trousers and jacket, 1 coat, 2 backpack, 3 short sleeves and shorts
    """

    STYLES = 4

    def __init__(self) -> None:
        phases = 2.0 * math.pi * np.arange(_PHASES) / _PHASES
        self._walking = [
            [figure(float(phase), style, _SWING_RAD) for phase in phases] for style in range(self.STYLES)
        ]
        self._standing = [figure(1.2, style, 0.06) for style in range(self.STYLES)]

    def figure(self, style: int, phase_rad: float, is_walking: bool) -> Figure:
        """The nearest of the figures; phase_rad: of the right leg's swing, 0 when it is foremost."""
        if not is_walking:
            return self._standing[style]
        return self._walking[style][round(phase_rad / (2.0 * math.pi) * _PHASES) % _PHASES]


def figure(phase_rad: float, style: int, swing_rad: float) -> Figure:
    """A person in one phase of a step. Hips swing as a cosine; the knee bends while the leg swings ahead."""
    triangles: list[Array] = []
    parts: list[int] = []

    def add(solid: Array, part: int) -> None:
        triangles.append(solid)
        parts.extend([part] * len(solid))

    share = swing_rad / _SWING_RAD
    for side, phase in ((-1.0, phase_rad), (1.0, phase_rad + math.pi)):
        _add_leg(
            add, side, swing_rad * math.cos(phase), 0.1 + 0.75 * share * max(0.0, -math.sin(phase)), style
        )
        _add_arm(add, side, -0.75 * swing_rad * math.cos(phase), 0.2 + 0.3 * share, style)
    _add_trunk(add, style)
    every = np.concatenate(triangles)
    every[:, :, 2] -= every[:, :, 2].min()
    return Figure(every.astype(np.float32), np.array(parts, dtype=np.int64))


def _add_trunk(add: AddSolid, style: int) -> None:
    hem_m = 0.55 if style == 1 else 0.86
    rings = [(hem_m, 0.155, 0.19), (0.95, 0.15, 0.18), (1.10, 0.14, 0.165), (1.30, 0.15, 0.19)]
    rings += [(1.38, 0.13, 0.20), (1.45, 0.10, 0.15), (1.49, 0.07, 0.08)]
    add(_loft([(0.0, 0.0, z) for z, _, _ in rings], [(rx, ry) for _, rx, ry in rings]), TOP)
    add(_loft([(0.0, 0.0, 1.46), (0.0, 0.0, 1.56)], [(0.05, 0.05), (0.05, 0.05)]), SKIN)
    angles = np.linspace(-0.45 * math.pi, 0.45 * math.pi, 7)
    centres = [(0.015, 0.0, 1.635 + 0.125 * math.sin(a)) for a in angles]
    add(_loft(centres, [(0.105 * math.cos(a), 0.085 * math.cos(a)) for a in angles]), SKIN)
    # The hair covers the back and the top of the head.
    tops = np.linspace(-0.1, 0.45, 5) * math.pi
    centres = [(-0.012, 0.0, 1.64 + 0.13 * math.sin(a)) for a in tops]
    add(_loft(centres, [(0.098 * math.cos(a), 0.093 * math.cos(a)) for a in tops]), HAIR)
    if style == 2:
        add(box((-0.30, -0.15, 1.0), (-0.09, 0.15, 1.42), 0.9), BAG)


def _add_leg(add: AddSolid, side: float, hip_rad: float, knee_rad: float, style: int) -> None:
    hip = np.array([0.0, 0.09 * side, 0.90])
    knee = hip + 0.43 * _down(hip_rad)
    shank_rad = hip_rad - knee_rad
    ankle = knee + 0.40 * _down(shank_rad)
    lower = SKIN if style == 3 else BOTTOM
    add(_loft([hip, 0.5 * (hip + knee), knee], [(0.11, 0.10), (0.095, 0.088), (0.078, 0.073)]), BOTTOM)
    add(_loft([knee, 0.6 * knee + 0.4 * ankle, ankle], [(0.078, 0.073), (0.075, 0.07), (0.06, 0.055)]), lower)
    foot = box((-0.07, -0.045, -0.075), (0.185, 0.045, 0.02), 0.9)
    tilt = 0.5 * shank_rad
    add(_turned(foot, tilt) + ankle, SHOES)


def _add_arm(add: AddSolid, side: float, shoulder_rad: float, elbow_rad: float, style: int) -> None:
    shoulder = np.array([0.0, 0.205 * side, 1.41])
    out = np.array([0.0, 0.035 * side, 0.0])
    elbow = shoulder + 0.29 * _down(shoulder_rad) + out
    wrist = elbow + 0.25 * _down(shoulder_rad + elbow_rad)
    hand = wrist + 0.10 * _down(shoulder_rad + elbow_rad)
    add(_loft([shoulder, elbow], [(0.07, 0.062), (0.055, 0.05)]), TOP)
    add(_loft([elbow, wrist], [(0.055, 0.05), (0.042, 0.04)]), SKIN if style == 3 else TOP)
    add(_loft([wrist, hand], [(0.034, 0.03), (0.03, 0.02)]), SKIN)


def _down(swing_rad: float) -> Array:
    """(3,) the way of a limb that hangs and swings forwards."""
    return np.array([math.sin(swing_rad), 0.0, -math.cos(swing_rad)])


def _turned(solid: Array, swing_rad: float) -> Array:
    cos, sin = math.cos(swing_rad), math.sin(swing_rad)
    turned = solid.copy()
    turned[:, :, 0] = cos * solid[:, :, 0] - sin * solid[:, :, 2]
    turned[:, :, 2] = sin * solid[:, :, 0] + cos * solid[:, :, 2]
    return turned


def _loft(centres: Sequence[Points], radii: Sequence[tuple[float, float]]) -> Array:
    """A closed tube of elliptic, level rings: centres (k, 3), radii (k, 2) along x and y."""
    middle, extent = np.array(centres, dtype=np.float64), np.array(radii, dtype=np.float64)
    angles = 2.0 * math.pi * np.arange(_SIDES + 1) / _SIDES
    ring = np.column_stack((np.cos(angles), np.sin(angles)))
    points = np.repeat(middle[:, None, :], _SIDES + 1, axis=1)
    points[:, :, :2] += extent[:, None, :] * ring[None]
    a, b = points[:-1, :-1], points[:-1, 1:]
    c, d = points[1:, 1:], points[1:, :-1]
    return quads(np.stack((a, b, c, d), axis=2).reshape(-1, 4, 3))
