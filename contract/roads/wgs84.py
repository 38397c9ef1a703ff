"""Between WGS 84 degrees and the map frame.

The map frame is east and north on the plane that touches the ellipsoid at the origin.

Points are taken at height 0. A distance on the plane is short of the one on the ground by less than 1 mm
at 4 km from the origin.
"""

import math

import numpy as np

from contract.geometry import Array
from contract.roads.model import Origin

_A_M = 6378137.0
_F = 1.0 / 298.257223563
_E2 = _F * (2.0 - _F)
_ROUNDS = 4


def map_from_wgs84(origin: Origin, latitude_deg: Array, longitude_deg: Array) -> Array:
    """(n, 2) metres east and north of the origin, from (n,) degrees."""
    offset = _ecef(np.asarray(latitude_deg, dtype=float), np.asarray(longitude_deg, dtype=float))
    offset -= _ecef(np.array([origin.latitude_deg]), np.array([origin.longitude_deg]))
    east, north = _axes(origin)
    moved: Array = np.column_stack((offset @ east, offset @ north))
    return moved


def wgs84_from_map(origin: Origin, points_map: Array) -> tuple[Array, Array]:
    """(latitude_deg, longitude_deg), each (n,), of (n, 2) points; inverse of `map_from_wgs84`.

    A few Newton steps with the ellipsoid's radii at the origin; exact to 1 um within 50 km.
    """
    points = np.asarray(points_map, dtype=float).reshape(-1, 2)
    sin2 = math.sin(math.radians(origin.latitude_deg)) ** 2
    prime_m = _A_M / math.sqrt(1.0 - _E2 * sin2)
    meridian_m = prime_m * (1.0 - _E2) / (1.0 - _E2 * sin2)
    parallel_m = prime_m * math.cos(math.radians(origin.latitude_deg))
    latitude: Array = np.full(len(points), origin.latitude_deg)
    longitude: Array = np.full(len(points), origin.longitude_deg)
    for _ in range(_ROUNDS):
        missing = points - map_from_wgs84(origin, latitude, longitude)
        latitude = latitude + np.degrees(missing[:, 1] / meridian_m)
        longitude = longitude + np.degrees(missing[:, 0] / parallel_m)
    return latitude, longitude


def _ecef(latitude_deg: Array, longitude_deg: Array) -> Array:
    phi, lam = np.radians(latitude_deg), np.radians(longitude_deg)
    prime_m = _A_M / np.sqrt(1.0 - _E2 * np.sin(phi) ** 2)
    xyz: Array = np.column_stack(
        (
            prime_m * np.cos(phi) * np.cos(lam),
            prime_m * np.cos(phi) * np.sin(lam),
            prime_m * (1.0 - _E2) * np.sin(phi),
        )
    )
    return xyz


def _axes(origin: Origin) -> tuple[Array, Array]:
    phi, lam = math.radians(origin.latitude_deg), math.radians(origin.longitude_deg)
    east = np.array([-math.sin(lam), math.cos(lam), 0.0])
    north = np.array([-math.sin(phi) * math.cos(lam), -math.sin(phi) * math.sin(lam), math.cos(phi)])
    return east, north
