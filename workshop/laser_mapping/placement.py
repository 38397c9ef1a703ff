"""Where GNSS fixes put the keyframes of a drive: dead reckoning, laid onto the fixes piece by piece.

Dead reckoning bends over kilometres, but not over the length of a piece. What lies between pieces with fixes
follows dead reckoning from the last one.
"""

import math

import numpy as np

from contract.geometry import Array, IntArray
from vehicle_agent.localization.laser.pose_arrays import between, composed
from workshop.cloud_mapping.gnss_fixes import Fixes, FixParams, places_of
from workshop.laser_mapping.keyframes import Keyframes
from workshop.laser_mapping.pose_graph import Edge, GraphParams, NodePlace, Optimized, optimized

# Half the length of a piece; two places a few metres apart give its direction.
_PIECE_M = 40.0
_SPAN_M_MIN = 10.0
# Dead reckoning by scans may come out short, in a street without corners; not by this factor.
_STRETCH_MAX = 2.0


class NotPlaced(ValueError):
    """The fixes do not say where the drive was; the message is one sentence."""


def node_places(
    keyframes: Keyframes, stamps_s: Array, fixes: Fixes, lever_laser: Array, params: FixParams
) -> tuple[NodePlace, ...]:
    """The fixes as places of keyframes. stamps_s (n,) of the scans; lever_laser (2,): the fixes' point.

    Raises NotPlaced when the vehicle moved and its scans did not.
    """
    _require_motion(float(way_m(keyframes.poses)[-1]), stamps_s, fixes, params)
    stamps_ns = np.rint(1e9 * stamps_s[keyframes.scans]).astype(np.int64)
    lever = np.array([lever_laser[0], lever_laser[1], 0.0])
    found = places_of(fixes, stamps_ns, way_m(keyframes.poses), lever, params)
    return tuple(
        NodePlace(place.node, place.lever_sensor[:2], place.place_map[:2], float(place.std_m[0]))
        for place in found
    )


def placed_poses(
    keyframes: Keyframes, places: tuple[NodePlace, ...], edges: tuple[Edge, ...], params: GraphParams
) -> Optimized:
    """The keyframes' poses in the map frame. Raises NotPlaced without fixes along 10 m of the way."""
    return optimized(_laid(keyframes.poses, places), edges, params, places)


def way_m(poses: Array) -> Array:
    """(n,) length of the way up to each pose."""
    steps = np.diff(poses[:, :2], axis=0)
    return np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])


def _require_motion(scanned_m: float, stamps_s: Array, fixes: Fixes, params: FixParams) -> None:
    of_the_log = (fixes.stamps_ns >= 1e9 * stamps_s[0]) & (fixes.stamps_ns <= 1e9 * stamps_s[-1])
    usable = fixes.places[of_the_log & (fixes.std_m[:, :2] <= params.std_m_max).all(axis=1), :2]
    if not len(usable):
        return
    # Without the outermost ones: a few wrong fixes are left to the graph.
    spans = np.diff(np.percentile(usable, (5.0, 95.0), axis=0), axis=0)[0]
    fixed_m = math.hypot(spans[0], spans[1])
    if fixed_m > _STRETCH_MAX * scanned_m + _SPAN_M_MIN:
        raise NotPlaced(
            f"The fixes lie up to {fixed_m:.0f} m apart, but the scans moved by {scanned_m:.1f} m: "
            "the scanner sees its own vehicle, or nothing that stands still. "
            "Mount it where it looks past the vehicle."
        )


def _laid(poses: Array, places: tuple[NodePlace, ...]) -> Array:
    way = way_m(poses)
    nodes: IntArray = np.array([place.node for place in places], dtype=np.int64)
    out = np.full_like(poses, np.nan)
    for number in range(len(poses)):
        near = np.flatnonzero(np.abs(way[nodes] - way[number]) <= _PIECE_M) if len(nodes) else nodes
        if len(near) >= 2 and np.ptp(way[nodes[near]]) >= _SPAN_M_MIN:
            out[number] = composed(_piece(poses, [places[i] for i in near]), poses[number])
    known = np.flatnonzero(np.isfinite(out[:, 0]))
    if not len(known):
        raise NotPlaced(f"The fixes do not cover {_SPAN_M_MIN:.0f} m of the drive, so the map has no place.")
    for missing in np.flatnonzero(~np.isfinite(out[:, 0])):
        number = int(missing)
        nearest = known[np.argmin(np.abs(way[known] - way[number]))]
        out[number] = composed(out[nearest], between(poses[nearest], poses[number]))
    return out


def _piece(poses: Array, places: list[NodePlace]) -> Array:
    """(3,) the frame of dead reckoning in the map, where the places are (Umeyama 1991, in the plane)."""
    levers = np.array([np.append(place.lever, 0.0) for place in places])
    ours = composed(poses[[place.node for place in places]], levers)[:, :2]
    true = np.array([place.place_map for place in places])
    weights = np.array([place.std_m**-2 for place in places])
    weights /= weights.sum()
    middle, target = weights @ ours, weights @ true
    a, b = ours - middle, true - target
    yaw = math.atan2(
        float(weights @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(weights @ (a * b).sum(axis=1))
    )
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array(
        [target[0] - cos * middle[0] + sin * middle[1], target[1] - sin * middle[0] - cos * middle[1], yaw]
    )
