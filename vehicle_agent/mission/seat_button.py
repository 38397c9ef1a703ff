"""Getting off early: the next place on the line where the vehicle can and may stop."""

import msgspec

from contract.roads.network import RoadNetwork
from vehicle_agent.mission.order_line import LanePoint, OrderLine
from vehicle_agent.mission.sections import VehicleExtent

_STEP_M = 0.5


class StopRules(msgspec.Struct, frozen=True):
    """Comfort of an unplanned stop: deceleration (m/s2), reaction (s) and room before the next stop (m)."""

    decel_mps2: float = 0.6
    reaction_s: float = 0.6
    before_stop_m: float = 6.0


def cut(
    network: RoadNetwork,
    line: OrderLine,
    s_m: float,
    speed_mps: float,
    limit_m: float,
    body: VehicleExtent,
    rules: StopRules,
) -> float | None:
    """Where the rear axle shall stand, on the line; None when there is no such place before limit_m.

    The whole body must stand on road lanes, clear of every section that a turn conflicts with: nobody shall
    get out in a junction.
    """
    first_m = s_m + speed_mps * rules.reaction_s + speed_mps**2 / (2.0 * rules.decel_mps2)
    barred = _barred(network, line)
    candidate_m = first_m
    while candidate_m <= limit_m:
        rear_m, front_m = candidate_m - body.back_m, candidate_m + body.front_m
        beyond = next((to_m for from_m, to_m in barred if from_m < front_m and to_m > rear_m), None)
        if beyond is None:
            return candidate_m
        candidate_m = max(candidate_m + _STEP_M, beyond + body.back_m)
    return None


def _barred(network: RoadNetwork, line: OrderLine) -> list[tuple[float, float]]:
    """Spans of the line that are in a junction, or that a turn through one crosses."""
    return [
        (from_m, to_m)
        for section_id, from_m, to_m in line.line.sections
        if any(
            network.lanes[network.sections[other].lane_id].kind != "road"
            for other in _touching(network, section_id)
        )
    ]


def _touching(network: RoadNetwork, section_id: str) -> tuple[str, ...]:
    return (section_id, *network.sections[section_id].conflicts)


class TemporaryStop(msgspec.Struct, frozen=True):
    """A stop that a passenger asked for; visit_id names it in events."""

    visit_id: str
    seat: int
    place: LanePoint
    s_m: float
