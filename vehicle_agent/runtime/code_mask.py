"""Boarding codes on the vehicle: masked on arrival, so that run logs and the vehicle's disk hold none.

The tick only compares codes. Both the order's and the typed one are replaced by the same keyed hash, so that
the comparison is unchanged, live and in replay. The key is the vehicle's: without one, the four digits of a
code could be found from its hash by trying all of them.
"""

import hmac

import msgspec

from contract.wire.messages import Order, RiderTask, Visit
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.signals import CodeTyped, DestinationChoice, InboxBody

# No rider can type it, so that a code that looks masked is masked.
_PREFIX = "#"
_HEX_CHARACTERS = 16


class CodeMask:
    """key: a secret of the vehicle, the same at every boot, since masked codes are on its disk."""

    def __init__(self, key: bytes) -> None:
        self._key = key

    def masked(self, body: InboxBody) -> InboxBody:
        """The value with its boarding codes masked; others unchanged."""
        if isinstance(body, CodeTyped | DestinationChoice):
            # A typed prefix is masked too: what is typed is never a masked code.
            return msgspec.structs.replace(body, code=self._digest(body.code)) if body.code else body
        return self._order(body) if isinstance(body, Order) else body

    def masked_memory(self, memory: MissionMemory) -> MissionMemory:
        """A memory from a disk on which an earlier version may have left codes."""
        order = None if memory.order is None else self._order(memory.order)
        return msgspec.structs.replace(memory, order=order, aboard=self._riders(memory.aboard))

    def _order(self, order: Order) -> Order:
        return msgspec.structs.replace(order, visits=tuple(self._visit(visit) for visit in order.visits))

    def _visit(self, visit: Visit) -> Visit:
        if not visit.board and not visit.alight:
            return visit
        return msgspec.structs.replace(
            visit, board=self._riders(visit.board), alight=self._riders(visit.alight)
        )

    def _riders(self, riders: tuple[RiderTask, ...]) -> tuple[RiderTask, ...]:
        return tuple(msgspec.structs.replace(rider, code=self._code(rider.code)) for rider in riders)

    def _code(self, code: str) -> str:
        return code if not code or code.startswith(_PREFIX) else self._digest(code)

    def _digest(self, code: str) -> str:
        return _PREFIX + hmac.digest(self._key, code.encode(), "sha256").hex()[:_HEX_CHARACTERS]
