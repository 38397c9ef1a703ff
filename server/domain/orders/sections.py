"""Which vehicle holds which sections of the road, and which it still needs."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class HeldSection:
    """A section that one vehicle alone may be in; a higher fence is a newer grant."""

    section_id: str
    fence: int


@dataclass(frozen=True, slots=True)
class Occupancy:
    """One vehicle on the road: what it holds, in driving order, and what its route still needs.

    goal      the section in which its route ends, None for a vehicle that has been placed and has no route
    held_ids  the sections of `held`
    """

    vehicle_id: str
    held: tuple[HeldSection, ...]
    ahead: tuple[str, ...]
    goal: str | None = None
    held_ids: tuple[str, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "held_ids", tuple(section.section_id for section in self.held))
