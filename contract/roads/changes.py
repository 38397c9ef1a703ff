"""What another version of a map changes for a shuttle that drives by the present one."""

import msgspec
import numpy as np

from contract.roads.model import Lane
from contract.roads.network import RoadNetwork


def changed_lanes(before: RoadNetwork, after: RoadNetwork) -> frozenset[str]:
    """The lanes of `before` on which a route by `before` is no route by `after`.

    A lane is the same if its line, width, speed limit, kind, passing and scenario tag are, if the same
    sections tile it, and if every lane that it led to still follows it. Conflicts of sections are not
    compared: they are looked up in the newer map when sections are granted. All lanes have changed if the
    map frame has another origin.
    """
    if before.road_map.origin != after.road_map.origin:
        return frozenset(before.lanes)
    return frozenset(lane_id for lane_id in before.lanes if not _is_same(before, after, lane_id))


def _is_same(before: RoadNetwork, after: RoadNetwork, lane_id: str) -> bool:
    if lane_id not in after.lanes:
        return False
    old, new = before.lanes[lane_id], after.lanes[lane_id]
    return (
        _driven(old) == _driven(new)
        and set(old.successors) <= set(new.successors)
        and np.array_equal(before.lines[lane_id].points, after.lines[lane_id].points)
        and _tiles(before, lane_id) == _tiles(after, lane_id)
    )


def _driven(lane: Lane) -> Lane:
    """Without its points, which the network has as an array, and what does not matter to driving."""
    return msgspec.structs.replace(lane, points=(), successors=(), name="", name_en="")


def _tiles(network: RoadNetwork, lane_id: str) -> list[tuple[str, float, float]]:
    return [(one.section_id, one.s_from_m, one.s_to_m) for one in network.sections_of(lane_id)]
