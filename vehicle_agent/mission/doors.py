"""The doors: commanded here, and taken as moved when the sensor confirms it."""

from typing import Literal

import msgspec

Phase = Literal["closed", "opening", "open", "closing"]


class Doors(msgspec.Struct, frozen=True):
    """phase since since_ns; sensed: the door sensor's last value, None without a sensor."""

    phase: Phase = "closed"
    since_ns: int = 0
    sensed: bool | None = None

    @property
    def commanded_open(self) -> bool:
        return self.phase in ("opening", "open")

    def sense(self, is_open: bool) -> "Doors":
        return Doors(self.phase, self.since_ns, is_open)

    def command(self, wanted_open: bool, now_ns: int) -> "Doors":
        """Starts to open or close the doors; no change if they already do."""
        if wanted_open == self.commanded_open:
            return self
        return Doors("opening" if wanted_open else "closing", now_ns, self.sensed)

    def step(self, now_ns: int, travel_ns: int) -> "Doors":
        """Open or closed when the sensor confirms it; without a sensor, after travel_ns."""
        if self.phase in ("open", "closed"):
            return self
        wanted = self.phase == "opening"
        arrived = self.sensed == wanted if self.sensed is not None else now_ns - self.since_ns >= travel_ns
        if not arrived:
            return self
        return Doors("open" if wanted else "closed", now_ns, self.sensed)
