"""Where people would be in a picture: regions of things on the ground."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.signals.pictures import PinholeCamera


class Regions(msgspec.Struct, frozen=True):
    """feet_px (k, 2) column and row; heights_px (k,) of a person there; is_seen (k,) bool: in the picture."""

    feet_px: Array
    heights_px: Array
    is_seen: np.ndarray


def person_regions(
    camera: PinholeCamera, feet_base: Array, height_m: float = 1.7, margin_ratio: float = 0.1
) -> Regions:
    """Regions of people who stand at feet_base (k, 3).

    margin_ratio  of a person's height that may be beyond the picture's edge

    A person who is nearer than the picture's rows reach is not seen: head or feet are cut off.
    """
    k = len(feet_base)
    T_camera_base = np.linalg.inv(camera.T_base_camera)
    feet = feet_base @ T_camera_base[:3, :3].T + T_camera_base[:3, 3]
    heads = feet + height_m * T_camera_base[:3, 2]
    is_ahead = (feet[:, 2] > 0.3) & (heads[:, 2] > 0.3)
    feet_px, heads_px = _pixels(camera.K, feet), _pixels(camera.K, heads)
    heights = np.where(is_ahead, feet_px[:, 1] - heads_px[:, 1], 1.0)
    margin = margin_ratio * heights
    inside = (feet_px[:, 0] >= 0.15 * heights - margin) & (
        feet_px[:, 0] <= camera.width_px - 0.15 * heights + margin
    )
    inside &= (heads_px[:, 1] >= -margin) & (feet_px[:, 1] <= camera.height_px + margin)
    assert feet_px.shape == (k, 2)
    return Regions(feet_px, heights, is_ahead & inside & (heights > 4.0))


def turned_region(
    camera: PinholeCamera, feet_px: tuple[float, float], height_px: float
) -> tuple[float, float]:
    """The same person's feet if the camera is mounted upside down, in its picture turned back."""
    return camera.width_px - 1 - feet_px[0], camera.height_px - 1 - (feet_px[1] - height_px)


def _pixels(K: Array, points: Array) -> Array:
    depth = np.where(points[:, 2] > 1e-3, points[:, 2], math.inf)
    u = K[0, 0] * points[:, 0] / depth + K[0, 2]
    v = K[1, 1] * points[:, 1] / depth + K[1, 2]
    return np.column_stack((u, v)).reshape(-1, 2)
