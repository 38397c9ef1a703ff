"""First guesses of one lidar's pose to another: from three planes that both see, or ground and guess."""

import itertools

import numpy as np

from contract.geometry import Array
from contract.transforms import transform_of
from workshop.calibration.planes import Plane, triples_of

_PLANES_MAX = 6
# Angles between planes as two sensors measure them.
_ANGLE_RAD = np.radians(4.0)
# The volume that three unit normals span: below it they are nearly in one plane and fix no position.
_VOLUME_MIN = 0.25
# Sensors of one vehicle.
_APART_M_MAX = 6.0
_UPRIGHT_MIN = 0.5
_GROUND_AREA_M2_MIN = 8.0


def from_planes(reference: list[Plane], other: list[Plane]) -> list[Array]:
    """T_reference_other (4, 4) of every way in which three planes of one can be three of the other.

    The rotation is Kabsch's over the three normals; three planes meet in a point, which gives the
    translation. Walls of a corner can be exchanged: what else is in the scene has to decide.
    """
    found: list[Array] = []
    reference, other = reference[:_PLANES_MAX], other[:_PLANES_MAX]
    for ours in triples_of(len(reference)):
        normals = np.array([reference[k].normal for k in ours])
        if abs(np.linalg.det(normals)) < _VOLUME_MIN:
            continue
        angles = _angles(normals)
        for theirs in itertools.permutations(range(len(other)), 3):
            their_normals = np.array([other[k].normal for k in theirs])
            if np.abs(_angles(their_normals) - angles).max() > _ANGLE_RAD:
                continue
            if np.linalg.det(normals) * np.linalg.det(their_normals) < 0.0:
                continue
            transform = np.eye(4)
            transform[:3, :3] = kabsch(their_normals, normals)
            # A plane n . p + d = 0 of the reference is R n' . p + d' - R n' . t = 0.
            ours_m, theirs_m = (
                [planes[k].offset_m for k in which] for planes, which in ((reference, ours), (other, theirs))
            )
            transform[:3, 3] = np.linalg.solve(normals, np.array(theirs_m) - np.array(ours_m))
            if np.linalg.norm(transform[:3, 3]) < _APART_M_MAX:
                found.append(transform)
    return found


def kabsch(theirs: Array, ours: Array) -> Array:
    """The rotation (3, 3) that brings the vectors `theirs` (n, 3) nearest to `ours` (Kabsch 1976)."""
    u, _, vt = np.linalg.svd(theirs.T @ ours)
    sign = np.sign(np.linalg.det(vt.T @ u.T))
    rotation: Array = vt.T @ np.diag([1.0, 1.0, sign]) @ u.T
    return rotation


def from_ground(reference: list[Plane], other: list[Plane], guess: Array) -> list[Array]:
    """The guess, turned by the least angle and lifted so that a ground of one is a ground of the other.

    Mounts are often tilted though drawings do not say so; what a guess lacks then is roll and pitch.
    """
    found: list[Array] = []
    for ours, theirs in itertools.product(_grounds(reference), _grounds(other)):
        normal = guess[:3, :3] @ theirs.normal
        transform = guess.copy()
        transform[:3, :3] = _least_turn(normal, ours.normal) @ guess[:3, :3]
        height = theirs.offset_m - ours.offset_m - float(ours.normal @ guess[:3, 3])
        transform[:3, 3] += height * ours.normal
        found.append(transform)
    return found


def turned(guess: Array, yaws_rad: Array) -> list[Array]:
    """The guess turned about the reference's z axis, the origin staying."""
    turns = []
    for yaw in yaws_rad:
        transform = transform_of(0.0, 0.0, float(yaw), np.zeros(3)) @ guess
        transform[:3, 3] = guess[:3, 3]
        turns.append(transform)
    return turns


def _grounds(planes: list[Plane]) -> list[Plane]:
    """Planes that can be the ground: large, and below the sensor."""
    return [
        plane
        for plane in planes[:_PLANES_MAX]
        if plane.normal[2] > _UPRIGHT_MIN and plane.area_m2 >= _GROUND_AREA_M2_MIN
    ][:2]


def _angles(normals: Array) -> Array:
    """(3,) between the first and second, first and third, second and third."""
    cosines = [normals[a] @ normals[b] for a, b in ((0, 1), (0, 2), (1, 2))]
    angles: Array = np.arccos(np.clip(cosines, -1.0, 1.0))
    return angles


def _least_turn(from_vector: Array, to_vector: Array) -> Array:
    """The rotation (3, 3) of one unit vector to another by the least angle."""
    axis = np.cross(from_vector, to_vector)
    cosine = float(from_vector @ to_vector)
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    rotation: Array = np.eye(3) + cross + cross @ cross / max(1.0 + cosine, 1e-6)
    return rotation
