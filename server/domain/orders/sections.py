"""Which vehicle holds which sections of the road, and which it still needs."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class HeldSection:
    """A section that one vehicle alone may be in; a higher fence is a newer grant."""

    section_id: str
    fence: int


@dataclass(frozen=True, slots=True)
class Occupancy:
    """One vehicle on the road: what it holds, in driving order, and what its route still needs.

    goal   the section in which its route ends, None for a vehicle that has been placed and has no route
    """

    vehicle_id: str
    held: tuple[HeldSection, ...]
    ahead: tuple[str, ...]
    goal: str | None = None

    @property
    def held_ids(self) -> tuple[str, ...]:
        return tuple(section.section_id for section in self.held)
