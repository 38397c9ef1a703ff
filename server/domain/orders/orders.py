"""Orders of vehicles, as they went over the wire but without boarding codes."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from contract.wire.messages import Order, Visit


class OrderState(StrEnum):
    ISSUED = "issued"
    ACCEPTED = "accepted"
    REJECTED = "rejected"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class IssuedOrder:
    """One revision of an order.

    plan_version  the plan that it carries out; a newer plan still waits for its route to be safe
    payload       what was sent, without boarding codes; epoch and grants are renewed when it is sent again
    """

    campus_id: str
    vehicle_id: str
    order_id: str
    revision: int
    plan_version: int
    state: OrderState
    payload: Order
    issued_at: datetime
    reason: str = ""


def lanes_of(visits: Sequence[Visit]) -> tuple[str, ...]:
    """The lanes to drive, in order, over all these visits."""
    lanes: list[str] = []
    for visit in visits:
        for lane_id in visit.route:
            if not lanes or lanes[-1] != lane_id:
                lanes.append(lane_id)
    return tuple(lanes)
