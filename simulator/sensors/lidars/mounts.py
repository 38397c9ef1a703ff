"""Where the lidars of a vehicle are."""

import math

import numpy as np

from contract.geometry import Array
from simulator.sensors.lidars.planar_scanner import PlanarMount
from simulator.sensors.lidars.spinning_lidar import MountedLidar
from vehicle_agent.config import Body, Profile
from vehicle_agent.config import PlanarScanner as PlanarScannerProfile
from vehicle_agent.lidar.models import HESAI, VLP16, XT16, LidarModel

_MAST_M = 0.35
_ARM_M = 0.08
_CORNER_M = 0.15


def mount(
    x_m: float, y_m: float, z_m: float, yaw_rad: float, tilt_rad: float = 0.0, roll_rad: float = 0.0
) -> Array:
    """(4, 4) T_base_level of a place whose x axis points to yaw_rad, and tilt_rad down."""
    cy, sy, cp, sp = math.cos(yaw_rad), math.sin(yaw_rad), math.cos(tilt_rad), math.sin(tilt_rad)
    cr, sr = math.cos(roll_rad), math.sin(roll_rad)
    pose: Array = np.eye(4)
    pose[:3, :3] = (
        np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        @ np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
        @ np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    )
    pose[:3, 3] = x_m, y_m, z_m
    return pose


def in_makers_frame(T_base_level: Array, model: LidarModel) -> Array:
    """(4, 4) T_base_sensor: a Hesai's y axis points where a Velodyne's x axis does."""
    if model.maker != HESAI:
        return T_base_level
    turned: Array = np.eye(4)
    turned[:2, :2] = [[0.0, 1.0], [-1.0, 0.0]]
    rotated: Array = T_base_level @ turned
    return rotated


def roof_lidar(body: Body, model: LidarModel = VLP16) -> MountedLidar:
    """One on a mast over the front of the roof, as on the GEM and the NUS cart."""
    at = mount(body.front_overhang_m - 0.3, 0.0, body.height_m + _MAST_M, 0.0)
    return MountedLidar("roof", in_makers_frame(at, model), model)


def lidars_of(profile: Profile, four: bool = False) -> tuple[MountedLidar, ...]:
    """A vehicle's lidars: four XT16, or the VLP-16 of its profile on a mast above the roof."""
    if four:
        return four_lidars(profile.body)
    place = profile.lidar
    z_m = max(place.z_m, profile.body.height_m + _MAST_M)
    at = mount(place.x_m, place.y_m, z_m, 0.0)
    return (MountedLidar("roof", in_makers_frame(at, VLP16), VLP16, place.rate_hz),)


def planar_mount(scanner: PlanarScannerProfile) -> PlanarMount:
    """The planar scanner of a profile: a SICK LMS151 at its place."""
    at = mount(scanner.x_m, scanner.y_m, scanner.z_m, scanner.yaw_rad)
    return PlanarMount(
        "planar", at, scanner.field_rad, scanner.step_rad, scanner.mirror_hz, (0.5, scanner.range_m_max)
    )


def four_lidars(body: Body, model: LidarModel = XT16) -> tuple[MountedLidar, ...]:
    """One on the roof, one over each front corner, one at the rear; three are tilted to the ground."""
    half, front, rear = 0.5 * body.width_m, body.front_overhang_m, -body.rear_overhang_m
    places = (
        ("top", mount(0.5 * (front + rear), 0.0, body.height_m + _MAST_M, 0.0)),
        ("left", mount(front - _CORNER_M, half + _ARM_M, 0.8 * body.height_m, 0.35 * math.pi, 0.2)),
        ("right", mount(front - _CORNER_M, -half - _ARM_M, 0.8 * body.height_m, -0.35 * math.pi, 0.2)),
        ("rear", mount(rear - _ARM_M, 0.0, 0.8 * body.height_m, math.pi, 0.2)),
    )
    return tuple(MountedLidar(name, in_makers_frame(at, model), model) for name, at in places)
