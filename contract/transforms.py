"""Rigid transforms as 4 x 4 matrices, and the angles that people write."""

import math

import numpy as np

from contract.geometry import Array


def transform_of(roll_rad: float, pitch_rad: float, yaw_rad: float, translation_m: Array) -> Array:
    """T: roll about x first, then pitch about y, then yaw about z of the fixed frame (REP-103)."""
    cr, sr, cp, sp = math.cos(roll_rad), math.sin(roll_rad), math.cos(pitch_rad), math.sin(pitch_rad)
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    transform = np.eye(4)
    transform[:3, :3] = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    transform[:3, 3] = translation_m
    return transform


def angles_of(transform: Array) -> tuple[float, float, float]:
    """(roll, pitch, yaw) in rad, as `transform_of` takes them."""
    rotation = transform[:3, :3]
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    pitch = math.atan2(-rotation[2, 0], math.hypot(rotation[2, 1], rotation[2, 2]))
    return roll, pitch, math.atan2(rotation[1, 0], rotation[0, 0])


def inverse(transform: Array) -> Array:
    """The transform back."""
    back = np.eye(4)
    back[:3, :3] = transform[:3, :3].T
    back[:3, 3] = -transform[:3, :3].T @ transform[:3, 3]
    return back


def moved(transform: Array, points: Array) -> Array:
    """Points (n, 3) in the frame that the transform leads to."""
    result: Array = points @ transform[:3, :3].T + transform[:3, 3]
    return result


def rotation_of(vector_rad: Array) -> Array:
    """(3, 3) of a rotation vector; Rodrigues."""
    angle = float(np.linalg.norm(vector_rad))
    x, y, z = vector_rad / angle if angle > 1e-12 else vector_rad
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Array = np.eye(3) + cross
    if angle > 1e-12:
        rotation = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return rotation


def apart(one: Array, other: Array) -> tuple[float, float]:
    """(metres, rad) between two transforms: of their origins, and of their rotations."""
    turn = one[:3, :3].T @ other[:3, :3]
    sine = 0.5 * np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = math.atan2(float(sine), 0.5 * (float(np.trace(turn)) - 1.0))
    return float(np.linalg.norm(one[:3, 3] - other[:3, 3])), angle
