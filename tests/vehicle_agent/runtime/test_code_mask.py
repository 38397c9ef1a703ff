"""Masked boarding codes are compared as the codes are, and tell nothing of them."""

import msgspec

from contract.wire.messages import Order, RiderTask, Visit
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.runtime.code_mask import CodeMask
from vehicle_agent.runtime.inbox import Inbox
from vehicle_agent.signals import CodeTyped, SeatSensor

MASK = CodeMask(b"of this vehicle")
RIDER = RiderTask("ride-1", 2, "4821")
ORDER = Order(
    1, "order-1", 1, "map", (Visit("v-1", "stop", "stop", "lane", 0.0, (), (RIDER,), (RIDER,)),), (), 0
)


def arrived(body: object) -> object:
    inbox = Inbox(mask=MASK)
    inbox.put(0, "link", body)  # type: ignore[arg-type]
    return inbox.drain()[0].body


def test_the_typed_code_of_a_rider_is_still_equal_to_the_orders() -> None:
    order, typed, other = arrived(ORDER), arrived(CodeTyped(1, "4821")), arrived(CodeTyped(1, "4822"))
    assert isinstance(order, Order)
    assert isinstance(typed, CodeTyped)
    assert isinstance(other, CodeTyped)
    visit = order.visits[0]
    assert visit.board[0].code == visit.alight[0].code == typed.code
    assert other.code != typed.code


def test_nothing_of_the_code_is_left_in_what_is_recorded() -> None:
    recorded = msgspec.msgpack.encode([arrived(ORDER), arrived(CodeTyped(1, "4821"))])
    assert b"4821" not in recorded


def test_another_vehicle_masks_the_same_code_differently() -> None:
    other = CodeMask(b"of another vehicle")
    assert other.masked(ORDER) != MASK.masked(ORDER)


def test_a_memory_of_a_former_version_is_masked_once() -> None:
    former = MissionMemory(order=ORDER, aboard=(RIDER,))
    masked = MASK.masked_memory(former)
    assert masked.aboard[0].code == MASK.masked(CodeTyped(1, "4821")).code  # type: ignore[union-attr]
    assert masked.order == MASK.masked(ORDER)
    assert MASK.masked_memory(masked) == masked


def test_a_masked_code_read_from_a_disk_cannot_be_typed() -> None:
    stolen = MASK.masked(ORDER).visits[0].board[0].code  # type: ignore[union-attr]
    assert arrived(CodeTyped(1, stolen)) != CodeTyped(1, stolen)


def test_other_values_and_riders_without_a_code_are_unchanged() -> None:
    assert arrived(SeatSensor(1, 2)) == SeatSensor(1, 2)
    assert arrived(CodeTyped(1, "")) == CodeTyped(1, "")
    uncoded = msgspec.structs.replace(
        ORDER, visits=(msgspec.structs.replace(ORDER.visits[0], board=(), alight=(RiderTask("r", 1),)),)
    )
    assert arrived(uncoded) == uncoded
