"""Stop and yield signs: those that are tagged, and by rule where a small road meets a bigger one.

The rule takes an intersection's stop lines, of each lane from a road with a lower speed limit than another
way into the same intersection: a stop sign where that one's is at least 1.45 times as high, else a yield sign
from 1.25 times on. OpenStreetMap tags hardly any signs; a campus has them where its roads meet the town's.
"""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
import shapely

from contract.geometry import arc_lengths, project
from contract.roads.model import ObservationArea, RoadSign, SignKind
from server.feeds.roads.lanes.drafts import LaneDraft
from server.feeds.roads.osm.frame import Frame
from server.feeds.roads.osm.osm_file import OsmData

STOP_FROM_RATIO, YIELD_FROM_RATIO = 1.45, 1.25
_TAGGED: Mapping[str, SignKind] = {"stop": "stop", "give_way": "yield"}
_ON_ROAD_M = 2.5
# A sign that is tagged so near to a stop line is the one that the rule would put there.
_SAME_M = 15.0


def road_signs(
    data: OsmData,
    frame: Frame,
    drafts: Sequence[LaneDraft],
    areas: Sequence[ObservationArea],
    *,
    left_hand: bool,
) -> tuple[RoadSign, ...]:
    """Tagged signs by node, then those by rule in the order of the areas; at most one for a stop line."""
    side: Literal["left", "right"] = "left" if left_hand else "right"
    found = list(_tagged(data, frame, drafts, side))
    by_id = {draft.lane_id: draft for draft in drafts}
    for area in areas:
        if area.kind == "intersection":
            found += _by_rule(area, by_id, side, found)
    return tuple(found)


def _tagged(
    data: OsmData, frame: Frame, drafts: Sequence[LaneDraft], side: Literal["left", "right"]
) -> list[RoadSign]:
    """Each on the nearest lane of its direction; without one, on the lane that ends nearer to the sign."""
    roads = [draft for draft in drafts if draft.kind == "road"]
    lines = [shapely.LineString(draft.points) for draft in roads]
    tree = shapely.STRtree(lines)
    found = []
    for node in sorted(data.nodes.values(), key=lambda node: node.node_id):
        kind = _TAGGED.get(node.tags.get("highway", ""))
        place = frame.positions.get(node.node_id)
        if kind is None or place is None:
            continue
        point = shapely.Point(place)
        near = [int(i) for i in sorted(tree.query(point, predicate="dwithin", distance=_ON_ROAD_M))]
        wanted = {"forward": "f", "backward": "b"}.get(node.tags.get("direction", ""))
        near = [i for i in near if wanted is None or roads[i].lane_id.endswith(wanted)]
        if not near:
            continue
        draft = roads[min(near, key=lambda i: (_left_m(roads[i], place), i))]
        s_m = float(project(draft.points, arc_lengths(draft.points), *place, 0, len(draft.points))[0])
        found.append(RoadSign(f"sign-{node.node_id}", kind, draft.lane_id, round(s_m, 3), side))
    return found


def _left_m(draft: LaneDraft, place: tuple[float, float]) -> float:
    """From a place to the end of the lane."""
    return float(np.hypot(*(draft.points[-1] - np.array(place))))


def _by_rule(
    area: ObservationArea,
    by_id: Mapping[str, LaneDraft],
    side: Literal["left", "right"],
    known: Sequence[RoadSign],
) -> list[RoadSign]:
    limits = {lane_id: by_id[lane_id].speed_limit_mps for lane_id, _ in area.stop_lines}
    highest_mps = max(limits.values())
    found: list[RoadSign] = []
    for lane_id, s_m in area.stop_lines:
        ratio = highest_mps / limits[lane_id]
        is_tagged = any(sign.lane_id == lane_id and abs(sign.s_m - s_m) < _SAME_M for sign in known)
        if ratio < YIELD_FROM_RATIO or is_tagged:
            continue
        kind: SignKind = "stop" if ratio >= STOP_FROM_RATIO else "yield"
        sign_id = f"sign-{area.area_id}-{lane_id}"
        if all(sign.sign_id != sign_id for sign in (*known, *found)):
            found.append(RoadSign(sign_id, kind, lane_id, s_m, side))
    return found
