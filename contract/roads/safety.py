"""Whether vehicles that share single tracks can all come to the ends of their routes.

A state is *safe* when the vehicles can, moving one at a time while all others stand, all come to the ends of
their routes; on the way they wait only where they block no other vehicle (the banker's algorithm: Dijkstra,
EWD 108, 1965; Habermann 1969). docs/contract/roads.md has the proofs.

Sets of sections are integers, one bit a section.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache, reduce
from operator import or_
from typing import NamedTuple

from contract.roads.design_vehicle import LENGTH_M, RELEASE_MARGIN_M, STANDING_MARGIN_M
from contract.roads.load import MapError
from contract.roads.model import Section

# What a vehicle lies over that has driven up to the end of what it holds.
_STANDING_M = LENGTH_M + STANDING_MARGIN_M + RELEASE_MARGIN_M

# Routes whose places to wait are remembered: those of a large fleet, and of the grants it asks for in turn.
_WAYS_KNOWN = 1024


class Place(NamedTuple):
    """Where a vehicle can wait on its route, lying over nothing else.

    road    the sections from the place before up to this one
    shadow  what it keeps others out of there; need: what is left of its route after it
    """

    road: int
    shadow: int
    need: int


@dataclass(frozen=True, slots=True)
class Claim:
    """One vehicle as the safety test sees it.

    need        the sections of its route that it does not hold; places: where it can wait on them, in order
    shadow_now  what it keeps others out of where it is; shadow_end: at its route's end
    """

    vehicle_id: str
    is_moving: bool
    places: Sequence[Place]
    need: int
    shadow_now: int
    shadow_end: int


class FreeWay(Enum):
    """How far a vehicle could drive at once: to its end, to a place to wait, or to neither."""

    TO_THE_END = "to the end"
    TO_A_PLACE = "to a place"
    NONE = "none"


class Ground:
    """The sections of one map as bits, and what a vehicle in each of them keeps others out of.

    Raises MapError for a section that conflicts with an unknown one.
    """

    def __init__(self, sections: Iterable[Section]) -> None:
        listed = list(sections)
        self.bits = {section.section_id: 1 << i for i, section in enumerate(listed)}
        try:
            self.shadows = {
                section.section_id: self.mask((section.section_id, *section.conflicts)) for section in listed
            }
        except KeyError as error:
            raise MapError("dangling_id", f"a section conflicts with unknown section {error}") from error
        self._followed_by = _places_to_wait(listed)
        self.places = lru_cache(_WAYS_KNOWN)(self._places)

    def mask(self, section_ids: Iterable[str]) -> int:
        return union(map(self.bits.__getitem__, section_ids))

    def shadow(self, section_ids: Iterable[str]) -> int:
        return union(map(self.shadows.__getitem__, section_ids))

    def stuck(self, claims: Sequence[Claim]) -> frozenset[str]:
        """The vehicles that no order of moves brings to their ends.

        A vehicle may move to its end, or up to where it blocks no other vehicle; and one that blocks no
        other and whose own way no end and no standing vehicle will block may go last. Each of these only
        shrinks what the rest is kept out of, so that a greedy choice finds such an order if there is one.
        """
        waiting = [claim for claim in claims if claim.is_moving]
        standing = {claim.vehicle_id: claim.shadow_now for claim in claims}
        while waiting:
            left = self._after_a_pass(waiting, standing)
            if left is None:
                return frozenset(claim.vehicle_id for claim in waiting)
            waiting = left
        return frozenset()

    def free_way(self, claim: Claim, others: Sequence[Claim]) -> FreeWay:
        """Where it could drive at once and block no other vehicle there."""
        wanted = union(other.need for other in others if other.is_moving)
        in_the_way = union(other.shadow_now for other in others)
        if not claim.need & in_the_way and not claim.shadow_end & wanted:
            return FreeWay.TO_THE_END
        is_part = _part_of_the_way(claim, in_the_way, wanted) is not None
        return FreeWay.TO_A_PLACE if is_part else FreeWay.NONE

    def _after_a_pass(self, waiting: Sequence[Claim], standing: dict[str, int]) -> list[Claim] | None:
        """Move whom it can, in `standing` too; returns those that still wait, None where nobody moved.

        What is wanted and what is in the way is that of the pass's beginning: moves only make both less, so
        that nobody moves who may not, and the next pass sees the rest.
        """
        needs, shadows = _Overlap(claim.need for claim in waiting), _Overlap(standing.values())
        at_the_end: _Overlap | None = None
        left: list[Claim] = []
        has_moved = False
        for place, claim in enumerate(waiting):
            wanted = needs.without(claim.need)
            in_the_way = shadows.without(standing[claim.vehicle_id])
            if not claim.need & in_the_way and not claim.shadow_end & wanted:
                standing[claim.vehicle_id] = claim.shadow_end
                has_moved = True
                continue
            if not claim.shadow_now & wanted:
                at_the_end = at_the_end or _at_the_end(waiting, standing)
                if not claim.need & at_the_end.without(claim.shadow_end):
                    # It goes after all others, which therefore have to count with it where it stands.
                    return [*left, *waiting[place + 1 :]]
            moved = _part_of_the_way(claim, in_the_way, wanted)
            if moved is not None:
                standing[claim.vehicle_id] = moved.shadow_now
                has_moved = True
            left.append(moved or claim)
        return left if has_moved else None

    def _places(self, foremost: str, ahead: tuple[str, ...]) -> tuple[Place, ...]:
        """The places to wait on a route, from the last section held on. `places` remembers them."""
        needs = [0]
        for section_id in reversed(ahead):
            needs.append(needs[-1] | self.bits[section_id])
        needs.reverse()
        found: list[Place] = []
        here, road = foremost, 0
        for section_id, need in zip(ahead, needs, strict=False):
            if self._followed_by.get(here) == section_id:
                found.append(Place(road, self.shadows[here], need))
                road = 0
            here = section_id
            road |= self.bits[here]
        return tuple(found)


def _part_of_the_way(claim: Claim, in_the_way: int, wanted: int) -> Claim | None:
    """The vehicle at the farthest place that it can reach and no other needs; None if there is none."""
    farthest = None
    for number, (road, shadow, _) in enumerate(claim.places):
        if road & in_the_way:
            break
        if not shadow & wanted:
            farthest = number
    if farthest is None:
        return None
    road, shadow, need = claim.places[farthest]
    if not road and shadow == claim.shadow_now:
        return None  # it is there already
    return Claim(claim.vehicle_id, True, claim.places[farthest + 1 :], need, shadow, claim.shadow_end)


class _Overlap:
    """Sets of sections. The union of all but one is found without another walk through them."""

    __slots__ = ("_any", "_several")

    def __init__(self, masks: Iterable[int]) -> None:
        found = several = 0
        for mask in masks:
            several |= found & mask
            found |= mask
        self._any, self._several = found, several

    def without(self, mask: int) -> int:
        """The union of all but this one, which must be one of them."""
        return self._any & ~(mask & ~self._several)


def _at_the_end(waiting: Sequence[Claim], standing: Mapping[str, int]) -> _Overlap:
    """What each vehicle keeps others out of once all that still wait are at their ends."""
    ends = {claim.vehicle_id: claim.shadow_end for claim in waiting}
    return _Overlap(ends.get(vehicle_id, shadow) for vehicle_id, shadow in standing.items())


def _places_to_wait(sections: list[Section]) -> dict[str, str]:
    """Sections that hold a whole vehicle, and the one that follows on the same lane.

    Only there a vehicle is known to lie over nothing else: at a lane's end it could be about to turn off.
    """
    starts = {(section.lane_id, section.s_from_m): section.section_id for section in sections}
    return {
        section.section_id: starts[section.lane_id, section.s_to_m]
        for section in sections
        if section.s_to_m - section.s_from_m >= _STANDING_M and (section.lane_id, section.s_to_m) in starts
    }


def union(masks: Iterable[int]) -> int:
    """All of them together."""
    return reduce(or_, masks, 0)
