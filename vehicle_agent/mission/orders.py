"""Accepting or rejecting orders: the vehicle's half of the authority rule."""

import msgspec

from contract.roads.network import RoadNetwork
from contract.wire.messages import Order, OrderAccepted, OrderRejected, Visit, VisitProgress
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.mission.order_line import LanePoint, OrderLine, VisitUnreachable, order_line


def is_repeat(order: Order, memory: MissionMemory) -> bool:
    """The vehicle already follows this order and revision."""
    known = memory.order
    return known is not None and (order.order_id, order.revision) == (known.order_id, known.revision)


def order_rejection(
    order: Order, memory: MissionMemory, network: RoadNetwork, server_now_ns: int | None
) -> OrderRejected | None:
    """The rejection of an order, as far as it shows without routing; None when it may be accepted.

    server_now_ns  None while the link has not measured the clock offset; the order is rejected as expired
    """
    if _is_stale(order, memory):
        return _rejected(
            order, memory, "stale_revision", "a higher revision or a later order was taken already"
        )
    if server_now_ns is None:
        return _rejected(order, memory, "expired", "the clocks have not been compared; send it again after")
    if server_now_ns > order.expires_ns:
        late_s = (server_now_ns - order.expires_ns) * 1e-9
        return _rejected(order, memory, "expired", f"came {late_s:.1f} s after it expired")
    if order.map_version != network.map_version:
        return _rejected(order, memory, "map_version", f"the vehicle drives by map {network.map_version}")
    flaw = _flaw(order, network)
    if flaw:
        return _rejected(order, memory, "malformed", flaw)
    clash = _clash(order, memory)
    if clash:
        return _rejected(order, memory, "visit_under_way", clash)
    return None


def with_order(
    order: Order, memory: MissionMemory, network: RoadNetwork, start: LanePoint, line_id: int
) -> tuple[MissionMemory, OrderLine] | OrderRejected:
    """(memory, line) with the order, or its rejection as unreachable."""
    states = {p.visit_id: p.state for p in memory.visits}
    progress = tuple(
        VisitProgress(visit.visit_id, states.get(visit.visit_id, "pending")) for visit in order.visits
    )
    try:
        line = order_line(network, order.visits, start, line_id)
    except VisitUnreachable as error:
        return _rejected(order, memory, "unreachable", str(error))
    past = memory.past
    if memory.order is not None and memory.order.order_id != order.order_id:
        past = (*past, (memory.order.order_id, memory.order.revision))[-16:]
    grants = tuple(grant for grant in order.sections if grant not in memory.released)
    new = msgspec.structs.replace(memory, order=order, visits=progress, past=past, grants=grants)
    return new, line


def order_accepted(order: Order) -> OrderAccepted:
    return OrderAccepted(order.epoch, order.order_id, order.revision)


def _rejected(order: Order, memory: MissionMemory, code: str, detail: str) -> OrderRejected:
    return OrderRejected(
        order.epoch,
        order.order_id,
        order.revision,
        code,  # type: ignore[arg-type]
        detail,
        memory.visits,
    )


def _is_stale(order: Order, memory: MissionMemory) -> bool:
    known = memory.order
    if known is not None and order.order_id == known.order_id:
        return order.revision < known.revision
    return any(order.order_id == order_id for order_id, _ in memory.past)


def _flaw(order: Order, network: RoadNetwork) -> str:
    if not order.visits:
        return "an order needs at least a rest visit"
    names = [visit.visit_id for visit in order.visits]
    if len(set(names)) < len(names):
        return "two visits have the same id"
    if order.visits[-1].kind != "rest":
        return "the last visit must be a rest visit"
    return next((flaw for visit in order.visits if (flaw := _visit_flaw(visit, network))), "")


def _visit_flaw(visit: Visit, network: RoadNetwork) -> str:
    unknown = [lane for lane in (*visit.route, visit.lane_id) if lane not in network.lanes]
    if unknown:
        return f"visit {visit.visit_id}: the map has no lane {unknown[0]}"
    if not -0.01 <= visit.s_m <= network.lines[visit.lane_id].length_m + 0.01:
        return f"visit {visit.visit_id}: {visit.s_m} m is not on lane {visit.lane_id}"
    if not 0.0 <= visit.dwell_s <= 3600.0:
        return f"visit {visit.visit_id}: a dwell of {visit.dwell_s} s"
    if any(rider.party < 1 for rider in (*visit.board, *visit.alight)):
        return f"visit {visit.visit_id}: a party has at least one person"
    return ""


def _clash(order: Order, memory: MissionMemory) -> str:
    behind = next((v.visit_id for v in order.visits if v.visit_id in memory.behind), "")
    if behind:
        return f"visit {behind} has been made already"
    under_way = memory.under_way
    if not under_way:
        return ""
    assert memory.order is not None
    standing = next(v for v in memory.order.visits if v.visit_id == under_way)
    first = order.visits[0]
    same_place = (first.visit_id, first.lane_id, first.s_m) == (under_way, standing.lane_id, standing.s_m)
    return (
        "" if same_place else f"the vehicle stands at visit {under_way}, which must stay first and in place"
    )
