"""A path as a road map of one lane, for scenes without a campus."""

import math

import numpy as np

from contract.geometry import Array, arc_lengths, resample
from contract.roads.load import decode_map, encode_map
from contract.roads.model import (
    Building,
    Lane,
    ObservationArea,
    Origin,
    RestingPlace,
    RoadMap,
    Scenario,
    Section,
)

LANE_ID = "path"
ORIGIN = Origin(31.3, 121.4)
_SPACING_M = 0.5


def path_map(
    name: str,
    points: Array,
    *,
    width_m: float,
    speed_limit_mps: float,
    scenario: Scenario = "common_road",
    buildings: tuple[Building, ...] = (),
    areas: tuple[ObservationArea, ...] = (),
) -> RoadMap:
    """One lane along the (n, 2) rear-axle path, in one section, with a resting place at its end.

    areas: their stop lines name LANE_ID. ValueError for a path shorter than 2 m.
    """
    resampled = resample(np.ascontiguousarray(points, dtype=np.float64), _SPACING_M)
    length_m = float(arc_lengths(resampled)[-1])
    if not math.isfinite(length_m) or length_m < 2.0:
        raise ValueError(f"{name}: a path to drive must be at least 2 m long")
    lane = Lane(
        LANE_ID,
        "road",
        tuple((float(x), float(y)) for x, y in resampled),
        width_m,
        speed_limit_mps,
        False,
        (),
        scenario,
    )
    section = Section(f"{LANE_ID}/0", LANE_ID, 0.0, length_m)
    place = RestingPlace("end", LANE_ID, length_m - 0.5)
    road_map = RoadMap(
        name, name, ORIGIN, (lane,), (section,), (), (place,), buildings, observation_areas=areas
    )
    return decode_map(encode_map(road_map))


def extended(points: Array, before_m: float, after_m: float) -> Array:
    """The (n, 2) path with straight extensions at both ends."""
    ahead, back = points[-1] - points[-2], points[0] - points[1]
    ahead, back = ahead / np.hypot(*ahead), back / np.hypot(*back)
    pieces = [points]
    if before_m > 0.0:
        pieces.insert(0, points[0] + back * np.arange(math.ceil(before_m), 0, -1)[:, None])
    if after_m > 0.0:
        pieces.append(points[-1] + ahead * np.arange(1, math.ceil(after_m) + 1)[:, None])
    longer: Array = np.vstack(pieces)
    return longer
