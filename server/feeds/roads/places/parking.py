"""Roads along car parks and their entrances: tagged `parking_lot`, where a parked car may pull out.

Aisles that are drawn and tagged as such are known by their tag. Many car parks are drawn as an area only,
and an underground one as the place of its entrance; cars come out of both onto the road beside them.
"""

from collections.abc import Iterable, Sequence

import shapely

from server.feeds.roads.lanes.drafts import LaneDraft
from server.feeds.roads.osm.buildings import Feature
from server.feeds.roads.osm.drivable import ROADS
from server.feeds.roads.osm.frame import Frame
from server.feeds.roads.osm.osm_file import OsmData

BESIDE_M = 12.0
# On faster roads than service roads cars do not manoeuvre.
_SPEED_MPS_MAX = ROADS["service"][0] / 3.6 + 0.01


def tag_parking(
    data: OsmData, frame: Frame, features: Iterable[Feature], drafts: Sequence[LaneDraft]
) -> tuple[str, ...]:
    """Tags the lanes; what was assumed, one line for each car park or entrance with a road beside it."""
    grounds = [
        (f"car park {f.feature_id}", f.outline) for f in features if f.tags.get("amenity") == "parking"
    ]
    grounds += [
        (f"car park entrance {node.node_id}", shapely.Point(frame.positions[node.node_id]))
        for node in data.nodes.values()
        if node.tags.get("amenity") == "parking_entrance" and node.node_id in frame.positions
    ]
    roads = [
        (draft, shapely.LineString(draft.points))
        for draft in drafts
        if draft.kind == "road" and draft.speed_limit_mps <= _SPEED_MPS_MAX
    ]
    assumed = []
    for name, ground in grounds:
        beside = [draft for draft, line in roads if line.distance(ground) <= BESIDE_M]
        for draft in beside:
            draft.scenario = "parking_lot"
        if beside:
            assumed.append(
                f"{name}: {', '.join(draft.lane_id for draft in beside)} taken for a parking aisle"
            )
    return tuple(assumed)
