"""The vehicle's part of the traces of rides: order received, accepted, first motion command, CAN frame."""

from collections.abc import Sequence

from contract.tracing import RideSpans, Spans, rides_of
from contract.wire.messages import Order, OrderAccepted
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.signals import Outputs


class LinkTracing:
    """What the link sees of an order. All times are UTC."""

    def __init__(self, spans: Spans, vehicle_id: str) -> None:
        self._rides = RideSpans(spans, vehicle_id=vehicle_id)
        self._received: tuple[Order, int] | None = None

    def received(self, message: object, utc_ns: int) -> None:
        """A message of the server."""
        if isinstance(message, Order):
            self._received = (message, utc_ns)
            self._rides.add(rides_of(message), "order.received", utc_ns, utc_ns, order_id=message.order_id)

    def answered(self, answers: Sequence[object], utc_ns: int) -> None:
        """Answers of the mission."""
        if self._received is None:
            return
        order, received_ns = self._received
        for answer in answers:
            if not isinstance(answer, OrderAccepted):
                continue
            if (answer.order_id, answer.revision) == (order.order_id, order.revision):
                fields = {"order_id": order.order_id}
                self._rides.add(rides_of(order), "order.accepted", received_ns, utc_ns, **fields)


class TickTracing:
    """The first tick that sets the vehicle in motion for a ride."""

    def __init__(self, spans: Spans, vehicle_id: str) -> None:
        self._rides = RideSpans(spans, vehicle_id=vehicle_id)
        self._order: Order | None = None
        self._waiting: tuple[str, ...] = ()
        self._since_ns = 0

    def moved(self, outputs: Outputs, memory: MissionMemory, utc_ns: int) -> tuple[str, ...]:
        """The rides for which these frames are the first ones with a throttle."""
        if memory.order is not self._order:
            self._order = memory.order
            self._waiting = () if memory.order is None else rides_of(memory.order)
            self._since_ns = utc_ns
        if not self._waiting:
            return ()
        actuation = outputs.flow.actuation
        if not (actuation.enable and actuation.throttle_ratio > 0.0):
            return ()
        waiting, self._waiting = self._waiting, ()
        return self._rides.add(waiting, "motion.commanded", self._since_ns, utc_ns)


class GateTracing:
    """The first CAN frame that the gate sends of such a tick."""

    def __init__(self, spans: Spans, vehicle_id: str) -> None:
        self._rides = RideSpans(spans, vehicle_id=vehicle_id)
        self._waiting: tuple[str, ...] = ()
        self._since_ns = 0

    def commanded(self, rides: tuple[str, ...], utc_ns: int) -> None:
        """The tick's frames have come that move the vehicle for these rides."""
        if rides:
            self._waiting, self._since_ns = (*self._waiting, *rides), utc_ns

    def sent(self, frames: int, is_braking: bool, utc_ns: int) -> None:
        """So many frames are on the bus: the tick's, unless the gate brakes."""
        if self._waiting and frames and not is_braking:
            waiting, self._waiting = self._waiting, ()
            self._rides.add(waiting, "can.frame_sent", self._since_ns, utc_ns)
