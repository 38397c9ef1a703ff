"""The shell around a vehicle's link session in virtual time: dials, moves frames, and dials again."""

from collections.abc import Callable

from campusloop.simulation.clocks import BootClock
from campusloop.simulation.schedule import Dialler, Schedule, VehicleEnd
from contract.wire.close_reasons import retry_after
from contract.wire.codec import WireError
from vehicle_agent.link.redial import Redial
from vehicle_agent.link.session import VehicleSession


class VehicleLink:
    """Of one boot of one vehicle, as `vehicle_agent.link.client`. `arrived` is called after each frame."""

    def __init__(
        self,
        vehicle_id: str,
        session: VehicleSession,
        clock: BootClock,
        network: Dialler,
        timeline: Schedule,
        arrived: Callable[[], None],
        redial: Redial,
    ) -> None:
        self._vehicle_id, self._session, self._clock = vehicle_id, session, clock
        self._network, self._timeline, self._arrived = network, timeline, arrived
        self._end: VehicleEnd | None = None
        self._redial = redial
        self._was_welcomed = False
        self._is_over = False
        self._frozen_frames: list[tuple[VehicleEnd, bytes]] | None = None
        self._dial()

    def flush(self) -> None:
        """Send what the session has to send."""
        if self._end is None or self._frozen_frames is not None:
            return
        for frame in self._session.take_outgoing():
            self._end.send(frame)

    def advance(self) -> None:
        """Once a second: probes, repeats, and the end of a connection on which nothing is heard."""
        now_ns = self._clock.now_ns()
        self._session.advance(now_ns)
        if self._end is not None and self._session.is_silent(now_ns):
            self._end.close(1001, "nothing heard")
            self._lost(self._end)
        self.flush()

    def send_raw(self, data: bytes) -> None:
        """A frame that no session would send."""
        if self._end is not None:
            self._end.send(data)

    def freeze(self) -> None:
        """The computer stands still: frames wait in the operating system."""
        self._frozen_frames = []

    def thaw(self) -> None:
        frames, self._frozen_frames = self._frozen_frames or [], None
        for end, data in frames:
            self._received(end, data)

    def drop(self) -> None:
        """The computer is gone; the server notices the closed connection."""
        self._is_over = True
        end, self._end = self._end, None
        if end is not None:
            end.close(1006, "reset")

    def _dial(self) -> None:
        if not self._is_over:
            self._network.dial(self._vehicle_id, self._opened)

    def _opened(self, end: VehicleEnd | None) -> None:
        if self._is_over:
            if end is not None:
                end.close(1006, "reset")
            return
        if end is None:
            self._dial_later()
            return
        self._end = end
        self._was_welcomed = False
        end.listen(lambda data: self._received(end, data), lambda _reason: self._lost(end))
        self._session.connected(self._clock.now_ns())

    def _received(self, end: VehicleEnd, data: bytes) -> None:
        if self._frozen_frames is not None:
            self._frozen_frames.append((end, data))
            return
        if end is not self._end:
            return
        try:
            self._session.received(data, self._clock.now_ns())
        except WireError as error:
            end.close(1002, error.detail)
            self._lost(end)
            return
        self._was_welcomed = self._was_welcomed or self._session.is_open
        self.flush()
        self._arrived()

    def _lost(self, end: VehicleEnd) -> None:
        if end is not self._end:
            return
        self._end = None
        self._session.disconnected(self._clock.now_ns())
        self._dial_later()
        self._arrived()

    def _dial_later(self) -> None:
        refusal = self._session.refusal
        retry = "later" if refusal is None else retry_after(refusal.code)
        wait_s = self._redial.wait_s(was_welcomed=self._was_welcomed, retry=retry)
        self._was_welcomed = False
        self._timeline.after(wait_s, self._dial)
