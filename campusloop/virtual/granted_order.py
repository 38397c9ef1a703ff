"""The messages of a server and an operator that make a vehicle drive, with all its sections granted."""

from collections.abc import Iterable

from contract.wire.messages import Command, Order, SectionGrant, Visit
from vehicle_agent.signals import LinkMessage, LinkState

FAR_FUTURE_NS = 10**18


def granted_order(
    order_id: str, map_version: str, visits: tuple[Visit, ...], section_ids: Iterable[str], epoch: int = 1
) -> Order:
    """An order that never expires, in the session of that epoch."""
    grants = tuple(SectionGrant(section_id, k) for k, section_id in enumerate(section_ids, start=1))
    return Order(epoch, order_id, 1, map_version, visits, grants, FAR_FUTURE_NS)


def rest_at(lane_ids: tuple[str, ...], s_m: float, stop_id: str = "") -> tuple[Visit, ...]:
    """One visit: to stand at s_m on the last of the lanes. stop_id: of the stop there, if there is one."""
    return (Visit("end", "rest", stop_id, lane_ids[-1], s_m, lane_ids),)


def start_messages(order: Order, now_ns: int) -> tuple[LinkMessage, ...]:
    """The link is connected, the order, and an operator's resume."""
    command = Command(order.epoch, f"go-{order.epoch}", "resume")
    return LinkState(now_ns, True, 1, 0), order, command
