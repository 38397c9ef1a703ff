"""The mission on another version of the map: when it may change over, and what it then remembers."""

from collections.abc import Collection
from dataclasses import dataclass

import msgspec

from contract.geometry import Pose2
from contract.roads.changes import changed_lanes
from contract.roads.network import RoadNetwork
from vehicle_agent.mission.order_line import locate
from vehicle_agent.mission.state import MissionState


@dataclass(frozen=True, slots=True)
class OffTheLanes:
    """The vehicle stands on no lane of the new map."""

    detail: str


def mission_on(
    state: MissionState, before: RoadNetwork, after: RoadNetwork, pose_map: Pose2
) -> MissionState | OffTheLanes | None:
    """The state with which the mission goes on in `after`; None: not at this moment.

    The vehicle must stand. While it executes an order, the rest of the order's line must be the same in both
    maps: then nothing of its state changes, whatever it is doing. Otherwise it finishes the order first.
    """
    if not state.standing_since_ns or state.pending_order is not None:
        return None
    changed = changed_lanes(before, after)
    if state.memory.open_visits() or state.temporary is not None:
        return state if changed.isdisjoint(_lanes_ahead(state)) else None
    place = locate(after, pose_map, ())
    if place is None:
        where = f"({pose_map.x_m:.1f}, {pose_map.y_m:.1f}) m"
        return OffTheLanes(f"the vehicle stands at {where}, on no lane of map {after.map_version}")
    kept = {
        section.section_id
        for lane_id in before.lanes.keys() - changed
        for section in before.sections_of(lane_id)
    }
    return _at_rest(state, kept).after(place=place, route=None, segment=0, is_off_route=False)


def _lanes_ahead(state: MissionState) -> frozenset[str]:
    """The lanes of the order's line; one that has no line yet waits for a position, on any lane."""
    route = state.route
    if route is None:
        return frozenset(
            lane for visit in state.memory.open_visits() for lane in (*visit.route, visit.lane_id)
        )
    return frozenset(route.line.lane_ids)


def _at_rest(state: MissionState, kept: Collection[str]) -> MissionState:
    """Without the grants of sections that the new map does not have: it cannot release them."""
    memory = state.memory
    occupied = tuple(one for one in state.occupied_sections if one.grant.section_id in kept)
    memory = msgspec.structs.replace(
        memory,
        grants=tuple(grant for grant in memory.grants if grant.section_id in kept),
        occupied=tuple(grant for grant in memory.occupied if grant.section_id in kept),
    )
    return state.after(memory=memory, occupied_sections=occupied)
