"""Random vehicles with several lidars at random wall corners, scanned with real beams and noise."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from contract.geometry import Array
from contract.transforms import transform_of
from vehicle_agent.lidar.models import HESAI, PANDAR64, VLP16, VLP32C, XT16, XT32, LidarModel

View = Literal["corner", "one_wall", "street"]
_MODELS = (VLP16, VLP32C, XT16, XT32, PANDAR64)
_COLUMNS = 1800
_RANGE_M_MAX = 60.0
_DROPOUT = 0.02
_AZIMUTH_STEP_RAD = math.radians(0.01)


@dataclass(frozen=True, slots=True)
class Noise:
    """Of data sheets: ranges deviate by each shot, and by each beam; beams point a little elsewhere.

    Velodyne states an accuracy of 3 cm, Hesai's XT of 1 cm and a precision of 0.5 cm.
    """

    shot_m: float
    beam_m: float
    elevation_rad: float = math.radians(0.02)


VELODYNE_NOISE, HESAI_NOISE = Noise(0.015, 0.008), Noise(0.006, 0.004)


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """An upright or level rectangle: corner + u * first + v * second, u and v from 0 to 1, scene frame."""

    corner: Array
    first: Array
    second: Array


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedRig:
    """models, clouds (n, 3) in each lidar's frame, and the truth T_reference_sensor (k, 4, 4)."""

    models: tuple[str, ...]
    clouds: tuple[Array, ...]
    truth: Array


def simulated_rig(view: View, rng: np.random.Generator) -> SimulatedRig:
    """A vehicle with two to four lidars before a corner, one wall, or in a street without ends."""
    faces = _scene(view, rng)
    lidars = int(rng.integers(2, 5))
    height_m = rng.uniform(1.4, 2.3)
    tilt = np.radians(rng.uniform(-3.0, 3.0, 2))
    reference = transform_of(tilt[0], tilt[1], rng.uniform(-math.pi, math.pi), np.array([0.0, 0.0, height_m]))
    truth = [np.eye(4)]
    for _ in range(lidars - 1):
        roll, pitch = np.radians(rng.uniform(-15.0, 15.0, 2))
        shift = np.append(rng.uniform(-1.5, 1.5, 2), rng.uniform(-0.6, 0.4))
        truth.append(transform_of(roll, pitch, rng.uniform(-math.pi, math.pi), shift))
    models = [_MODELS[k] for k in rng.integers(0, len(_MODELS), lidars)]
    clouds = [_scan(faces, reference @ pose, model, rng) for pose, model in zip(truth, models, strict=True)]
    return SimulatedRig(tuple(model.name for model in models), tuple(clouds), np.array(truth))


def _scene(view: View, rng: np.random.Generator) -> list[Face]:
    """The vehicle is at the origin, the ground at z = 0."""
    far = 2.0 * _RANGE_M_MAX
    faces = [Face(np.array([-far / 2, -far / 2, 0.0]), np.array([far, 0.0, 0.0]), np.array([0.0, far, 0.0]))]
    heading = rng.uniform(-math.pi, math.pi)
    if view == "corner":
        # Two walls that meet at an angle, both 2 to 8 m from the vehicle.
        opening = math.radians(rng.uniform(70.0, 110.0))
        near = rng.uniform(2.0, 8.0, 2)
        normals = [_level(heading), _level(heading + math.pi - opening)]
        corner = np.linalg.solve(np.array([normal[:2] for normal in normals]), near)
        for normal, other in ((normals[0], normals[1]), (normals[1], normals[0])):
            along = np.array([-normal[1], normal[0], 0.0])
            # Away from the other wall.
            along *= -math.copysign(1.0, float(along @ other))
            faces.append(_wall(np.append(corner, 0.0), along * rng.uniform(6.0, 14.0), rng.uniform(2.5, 6.0)))
    else:
        sides = (1.0, -1.0) if view == "street" else (1.0,)
        for side in sides:
            normal, along = _level(heading) * side, _level(heading + 0.5 * math.pi)
            middle = normal * rng.uniform(2.0, 6.0)
            faces.append(_wall(middle - 60.0 * along, 120.0 * along, rng.uniform(2.5, 6.0)))
        return faces
    for _ in range(int(rng.integers(0, 5))):
        faces += _box(rng)
    return faces


def _level(angle_rad: float) -> Array:
    return np.array([math.cos(angle_rad), math.sin(angle_rad), 0.0])


def _wall(foot: Array, along: Array, height_m: float) -> Face:
    return Face(foot, along, np.array([0.0, 0.0, height_m]))


def _box(rng: np.random.Generator) -> list[Face]:
    """A bin, a person or a parked thing beside the vehicle."""
    angle, reach = rng.uniform(-math.pi, math.pi), rng.uniform(2.5, 9.0)
    centre, turn = reach * _level(angle), rng.uniform(-math.pi, math.pi)
    length, width, height = rng.uniform(0.3, 1.8), rng.uniform(0.3, 1.0), rng.uniform(0.5, 1.8)
    first, second = length * _level(turn), width * _level(turn + 0.5 * math.pi)
    foot = centre - 0.5 * first - 0.5 * second
    return [
        _wall(foot, first, height), _wall(foot + second, first, height), _wall(foot, second, height),
        _wall(foot + first, second, height), Face(foot + np.array([0.0, 0.0, height]), first, second),
    ]  # fmt: skip


def _scan(faces: list[Face], pose: Array, model: LidarModel, rng: np.random.Generator) -> Array:
    """(n, 3) in the lidar's frame; pose is T_scene_sensor."""
    noise = HESAI_NOISE if model.maker == HESAI else VELODYNE_NOISE
    beams = len(model.elevations_rad)
    true_elevations = model.elevations_rad + rng.normal(0.0, noise.elevation_rad, beams)
    azimuths = 2.0 * math.pi * np.arange(_COLUMNS) / _COLUMNS
    azimuth = (azimuths[None, :] + model.azimuths_rad[:, None]).ravel()
    ranges = _ranges(faces, pose, _directions(azimuth, np.repeat(true_elevations, _COLUMNS)))
    ranges += np.repeat(rng.normal(0.0, noise.beam_m, beams), _COLUMNS) + rng.normal(
        0.0, noise.shot_m, len(ranges)
    )
    ranges = np.rint(ranges / model.distance_m) * model.distance_m
    kept = (ranges > model.range_m_min) & (ranges < _RANGE_M_MAX) & (rng.random(len(ranges)) > _DROPOUT)
    stated = np.rint(azimuth / _AZIMUTH_STEP_RAD) * _AZIMUTH_STEP_RAD
    directions = _directions(stated, np.repeat(model.elevations_rad, _COLUMNS))
    scanned: Array = ranges[kept, None] * directions[kept]
    return scanned


def _directions(azimuth: Array, elevation: Array) -> Array:
    level = np.cos(elevation)
    return np.column_stack((level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)))


def _ranges(faces: list[Face], pose: Array, directions: Array) -> Array:
    """Along each ray (n, 3) in the lidar's frame to the nearest face; inf without any."""
    rays, origin = directions @ pose[:3, :3].T, pose[:3, 3]
    nearest = np.full(len(rays), np.inf)
    for face in faces:
        normal = np.cross(face.first, face.second)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (normal @ (face.corner - origin)) / (rays @ normal)
            hits = origin + reach[:, None] * rays - face.corner
            u, v = (
                hits @ face.first / (face.first @ face.first),
                hits @ face.second / (face.second @ face.second),
            )
            inside = (reach > 0.0) & (u >= 0.0) & (u <= 1.0) & (v >= 0.0) & (v <= 1.0)
        nearest = np.where(inside & (reach < nearest), reach, nearest)
    return nearest
