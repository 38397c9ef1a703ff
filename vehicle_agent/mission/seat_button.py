"""Temporary stops on request: the next place on the line where the vehicle can and may stop."""

import msgspec

from contract.roads.network import RoadNetwork
from vehicle_agent.mission.order_line import LanePoint, OrderLine
from vehicle_agent.mission.sections import VehicleExtent

_STEP_M = 0.5


class StopRules(msgspec.Struct, frozen=True):
    """Comfort of a temporary stop: deceleration (m/s2), reaction (s), distance before the next stop (m)."""

    decel_mps2: float
    reaction_s: float = 0.6
    before_stop_m: float = 6.0


def next_stopping_place(
    network: RoadNetwork,
    line: OrderLine,
    s_m: float,
    speed_mps: float,
    limit_m: float,
    body: VehicleExtent,
    rules: StopRules,
) -> float | None:
    """The place of the rear axle on the line; None when there is none before limit_m.

    The whole body must stand on road lanes, clear of every section that conflicts with a turn, so that no
    passenger gets out in a junction, and clear of the map's no-stopping zones.
    """
    first_m = s_m + speed_mps * rules.reaction_s + speed_mps**2 / (2.0 * rules.decel_mps2)
    closed = sorted([*_junction_spans(network, line), *_zone_spans(network, line)])
    candidate_m = first_m
    while candidate_m <= limit_m:
        rear_m, front_m = candidate_m - body.back_m, candidate_m + body.front_m
        beyond = next((to_m for from_m, to_m in closed if from_m < front_m and to_m > rear_m), None)
        if beyond is None:
            return candidate_m
        candidate_m = max(candidate_m + _STEP_M, beyond + body.back_m)
    return None


def _junction_spans(network: RoadNetwork, line: OrderLine) -> list[tuple[float, float]]:
    """Spans of the line that are in a junction, or that a turn through a junction crosses."""
    return [
        (from_m, to_m)
        for section_id, from_m, to_m in line.line.sections
        if any(
            network.lanes[network.sections[other].lane_id].kind != "road"
            for other in _conflicting(network, section_id)
        )
    ]


def _zone_spans(network: RoadNetwork, line: OrderLine) -> list[tuple[float, float]]:
    """Spans of the line that lie in a no-stopping zone."""
    return [
        (begin_m + zone.s_from_m, begin_m + zone.s_to_m)
        for zone in network.road_map.no_stopping_zones
        for lane_id, begin_m in zip(line.line.lane_ids, line.lane_from_m, strict=True)
        if lane_id == zone.lane_id
    ]


def _conflicting(network: RoadNetwork, section_id: str) -> tuple[str, ...]:
    return (section_id, *network.sections[section_id].conflicts)


class TemporaryStop(msgspec.Struct, frozen=True):
    """A stop that a passenger requested; visit_id names it in events."""

    visit_id: str
    seat: int
    place: LanePoint
    s_m: float
