"""Which vehicle holds which sections of the road, and which it still needs."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class HeldSection:
    """A section that one vehicle alone may be in; a higher fence is a newer grant."""

    section_id: str
    fence: int


@dataclass(frozen=True, slots=True)
class Occupancy:
    """One vehicle on the road: what it holds, in driving order, and what its route still needs."""

    vehicle_id: str
    held: tuple[HeldSection, ...]
    ahead: tuple[str, ...]

    @property
    def held_ids(self) -> tuple[str, ...]:
        return tuple(section.section_id for section in self.held)
