"""Where people cross a driven road: tagged crossings, and footways that go on beyond the road."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
import shapely

from contract.geometry import arc_lengths, pose_at, project
from server.feeds.roads.lanes.drafts import LaneDraft
from server.feeds.roads.osm.drivable import Driving, driving
from server.feeds.roads.osm.frame import Frame
from server.feeds.roads.osm.osm_file import OsmData

ON_ROAD_M = 2.5
_FOOTWAYS = ("footway", "path", "steps", "cycleway", "pedestrian")


def crossing_nodes(data: OsmData, frame: Frame, drafts: Sequence[LaneDraft]) -> tuple[int, ...]:
    """Ids of the nodes, ascending: tagged ones, and those of a footway that leaves the road on both sides.

    A footway that ends at the road is none: people step out of it along the road as well.
    """
    tagged = {node.node_id for node in data.nodes.values() if node.tags.get("highway") == "crossing"}
    beyond = _neighbours(data, frame)
    lines = [shapely.LineString(draft.points) for draft in drafts]
    tree = shapely.STRtree(lines)
    for node_id, others in beyond.items():
        place = frame.positions[node_id]
        near = tree.query(shapely.Point(place), predicate="dwithin", distance=ON_ROAD_M)
        if not len(near) or node_id in tagged:
            continue
        nearest = min((lines[i].distance(shapely.Point(place)), int(i)) for i in near)[1]
        if _are_on_both_sides(drafts[nearest], place, [frame.positions[other] for other in others]):
            tagged.add(node_id)
    return tuple(sorted(tagged))


def _neighbours(data: OsmData, frame: Frame) -> dict[int, list[int]]:
    """The next nodes along footways, of each node that a footway shares with a driven way."""
    driven: set[int] = set()
    steps: dict[int, list[int]] = {}
    for way in data.ways.values():
        known = [ref for ref in way.nodes if ref in frame.positions]
        if isinstance(driving(way.tags), Driving):
            driven.update(known)
        elif way.tags.get("highway") in _FOOTWAYS:
            for one, other in itertools.pairwise(known):
                steps.setdefault(one, []).append(other)
                steps.setdefault(other, []).append(one)
    return {node_id: steps[node_id] for node_id in sorted(driven & steps.keys())}


def _are_on_both_sides(
    draft: LaneDraft, place: tuple[float, float], others: list[tuple[float, float]]
) -> bool:
    s = arc_lengths(draft.points)
    at_m, _, _ = project(draft.points, s, place[0], place[1], 0, len(s))
    yaw = float(pose_at(draft.points, s, at_m)[2])
    aside = np.array(others) - np.array(place)
    sides = math.cos(yaw) * aside[:, 1] - math.sin(yaw) * aside[:, 0]
    return bool(sides.max() > 0.0 > sides.min())
