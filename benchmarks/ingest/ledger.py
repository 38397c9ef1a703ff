"""What was sent and acknowledged, and after how long."""

from array import array
from collections import deque


class AckLedger:
    """An event is acknowledged when the server has said so; its time begins when it was due to be sent."""

    def __init__(self, vehicles: int) -> None:
        self.next_sequence = [0] * vehicles
        self.acknowledged_below = [0] * vehicles
        self.sent = 0
        self._due: list[deque[float]] = [deque() for _ in range(vehicles)]
        self._counted_from_s = float("inf")
        self._counted_to_s = float("inf")
        self.latencies_s = array("d")

    def begin(self, vehicle: int, stored: int) -> None:
        """The server had so many of its events already."""
        self.next_sequence[vehicle] = self.acknowledged_below[vehicle] = stored

    def count(self, from_s: float, to_s: float) -> None:
        """Keep the latencies of the events that were due between these moments."""
        self._counted_from_s, self._counted_to_s = from_s, to_s

    def send(self, vehicle: int, due_s: float) -> int:
        """The number of the next event."""
        sequence = self.next_sequence[vehicle]
        self.next_sequence[vehicle] = sequence + 1
        self._due[vehicle].append(due_s)
        self.sent += 1
        return sequence

    def acknowledged(self, vehicle: int, next_sequence: int, now_s: float) -> None:
        due, below = self._due[vehicle], self.acknowledged_below[vehicle]
        while below < next_sequence:
            due_s = due.popleft()
            if self._counted_from_s <= due_s < self._counted_to_s:
                self.latencies_s.append(now_s - due_s)
            below += 1
        self.acknowledged_below[vehicle] = below

    @property
    def unacknowledged(self) -> int:
        return sum(len(due) for due in self._due)
