"""How the world differs from the map, and from the day on which its surroundings were scanned."""

from dataclasses import dataclass


class SceneError(Exception):
    """The scene cannot be built; the message says which value is wrong."""


@dataclass(frozen=True, slots=True)
class WorldChanges:
    """Differences, drawn from a seed of their own. Shares are from 0 to 1.

    seed                  of what changes; the permanent surroundings have the scene's seed
    buildings_altered_ratio  buildings that got an annex, another height, or are gone
    trees_felled_ratio    trees that are gone
    parked_ratio          parking places that are taken; other seeds park other vehicles
    trucks_ratio          of the parked vehicles
    works                 building sites at the road, at most as many as have room: barriers, container, heap
    sway_m                how far the crowns of trees move in the wind, standard deviation
    """

    seed: int = 0
    buildings_altered_ratio: float = 0.0
    trees_felled_ratio: float = 0.0
    parked_ratio: float = 0.35
    trucks_ratio: float = 0.1
    works: int = 0
    sway_m: float = 0.05

    def __post_init__(self) -> None:
        """Raises SceneError for a share outside 0..1, or a negative number of works or sway."""
        for name in ("buildings_altered_ratio", "trees_felled_ratio", "parked_ratio", "trucks_ratio"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise SceneError(f"{name} is a share from 0 to 1, not {getattr(self, name)}")
        if self.works < 0 or not 0.0 <= self.sway_m <= 1.0:
            raise SceneError(
                f"works must not be negative and sway_m 0 to 1 m, not {self.works}, {self.sway_m}"
            )
