"""Who may drive into which section, so that shuttles never collide and never wait for each other in a ring.

A vehicle has the sections it holds (its body is in them, or was granted them) and the sections still ahead
on its route, whose last one is where it will stand. Only grants and routes that keep the state safe are given
(`safety`); docs/contract/roads.md proves that a fleet which starts at resting places never gets stuck.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from operator import is_

import msgspec

from contract.roads.model import Section
from contract.roads.safety import Claim, FreeWay, Ground, union


class Grant(msgspec.Struct, frozen=True):
    """The permission to enter a section; a grant with a higher fence is newer, for all sections."""

    section_id: str
    fence: int


class ReservationError(Exception):
    """A request that contradicts what the controller knows: a stable code and a detail."""

    def __init__(self, code: str, detail: str) -> None:
        super().__init__(f"{code}: {detail}")
        self.code = code
        self.detail = detail


@dataclass(frozen=True, slots=True)
class _Vehicle:
    """goal: the section in which its route ends; None for one that was placed and has no route.

    claim  the same for the safety test
    """

    held: tuple[str, ...]
    ahead: tuple[str, ...]
    goal: str | None
    claim: Claim


@dataclass(slots=True)
class _LastTest:
    """The state that was tested last, and which vehicles are stuck in it."""

    claims: list[Claim] = field(default_factory=list)
    stuck: frozenset[str] = frozenset()

    def is_of(self, claims: Sequence[Claim]) -> bool:
        """By identity: a claim is never changed, and most of a fleet is put back as it was."""
        return len(claims) == len(self.claims) and all(map(is_, claims, self.claims))


class Reservations:
    """The sections of one map and the vehicles on them. Vehicles are visited in the order of their ids.

    last_fence  the highest fence ever granted, kept over a restart so that fences go on growing.
    """

    def __init__(self, sections: Iterable[Section], last_fence: int = 0) -> None:
        self._ground = Ground(sections)
        self._vehicles: dict[str, _Vehicle] = {}
        # What was last put back of each vehicle: most of a fleet is put back as it was.
        self._restored: dict[str, _Vehicle] = {}
        self._last_test = _LastTest()
        self.last_fence = last_fence

    def emptied(self) -> "Reservations":
        """The same map without vehicles; data derived from the map are shared."""
        empty = Reservations(())
        empty._ground, empty._restored = self._ground, self._restored
        empty._last_test = self._last_test
        return empty

    @property
    def vehicle_ids(self) -> tuple[str, ...]:
        return tuple(sorted(self._vehicles))

    def held(self, vehicle_id: str) -> tuple[str, ...]:
        """The sections the vehicle holds, oldest first."""
        return self._vehicle(vehicle_id).held

    def ahead(self, vehicle_id: str) -> tuple[str, ...]:
        """The sections of the vehicle's route that it does not hold yet."""
        return self._vehicle(vehicle_id).ahead

    def is_safe(self) -> bool:
        """Every vehicle can still finish its route."""
        return not self._ground.stuck(self._claims())

    def place(self, vehicle_id: str, held: Sequence[str]) -> None:
        """Set the sections that a vehicle holds and delete its route: a new vehicle, or one after a restart.

        Where a vehicle stands is a fact, so this is never refused for safety's sake. Raises
        ReservationError: unknown_section, holds_nothing, conflict (two vehicles claim the same ground).
        """
        if not held:
            raise ReservationError("holds_nothing", f"{vehicle_id} must hold the section it stands in")
        self._check_known(held)
        wanted = self._ground.mask(held)
        for other_id in self.vehicle_ids:
            if other_id != vehicle_id and self._vehicles[other_id].claim.shadow_now & wanted:
                raise ReservationError(
                    "conflict",
                    f"{vehicle_id} and {other_id} claim the same ground; hold both and move one by hand",
                )
        self._vehicles[vehicle_id] = self._entered(vehicle_id, tuple(held), (), None)

    def restore(self, vehicle_id: str, held: Sequence[str], ahead: Sequence[str], goal: str | None) -> None:
        """Put back a vehicle exactly as it was stored: its sections, the rest of its route, and its end.

        Nothing is tested, since routes that are safe together need not be safe one by one. Raises
        ReservationError: unknown_section.
        """
        whole = (tuple(held), tuple(ahead), goal)
        known = self._restored.get(vehicle_id)
        if known is None or (known.held, known.ahead, known.goal) != whole:
            self._check_known((*held, *ahead, *(() if goal is None else (goal,))))
            known = self._restored[vehicle_id] = self._entered(vehicle_id, *whole)
        self._vehicles[vehicle_id] = known

    def remove(self, vehicle_id: str) -> None:
        """Remove a vehicle that has been taken off the roads."""
        self._vehicle(vehicle_id)
        del self._vehicles[vehicle_id]

    def adopt(self, vehicle_id: str, route_sections: Sequence[str]) -> bool:
        """Replace the vehicle's route; False, and nothing changed, where that would be unsafe.

        A vehicle that was placed and has no route yet may take one that cannot be finished now, as long as
        it locks in no other vehicle: two that block each other can only be freed by both routes.

        route_sections  in order, up to where the vehicle will stand. It must contain a section which the
        vehicle holds; what lies before the first such section is behind the vehicle. Held sections that are
        not on the new route stay held until they are released. Raises ReservationError: unknown_vehicle,
        unknown_section, off_route.
        """
        vehicle = self._vehicle(vehicle_id)
        self._check_known(route_sections)
        ahead = _rest_of_route(vehicle.held, route_sections)
        if ahead is None:
            raise ReservationError(
                "off_route", f"the route of {vehicle_id} does not touch a section it holds: {vehicle.held}"
            )
        before = self._stuck_now()
        turned = self._entered(vehicle_id, vehicle.held, ahead, route_sections[-1])
        tolerated = before | {vehicle_id} if vehicle.goal is None else before - {vehicle_id}
        stuck = self._ground.stuck(self._claims(vehicle_id, turned))
        if not stuck <= tolerated:
            return False
        self._put(vehicle_id, turned)
        self._last_test.claims, self._last_test.stuck = self._claims(), stuck
        return True

    def grant(self, vehicle_id: str, limit: int) -> tuple[Grant, ...]:
        """Take the longest safe run of at most `limit` sections ahead; empty where there is none yet."""
        vehicle = self._vehicle(vehicle_id)
        free = self._free_count(vehicle_id, limit)
        if free == 0:
            return ()
        for count in range(free, 0, -1):
            moved = self._moved(vehicle_id, vehicle, count)
            if self._take_if_safe(vehicle_id, moved):
                granted = vehicle.ahead[:count]
                return tuple(Grant(section_id, self._next_fence()) for section_id in granted)
        return ()

    def release(self, vehicle_id: str, section_id: str) -> bool:
        """The vehicle's tail has left the section. False where it did not hold it: a repeat is harmless.

        Raises ReservationError: holds_nothing for the last section held, since a vehicle stands somewhere.
        """
        vehicle = self._vehicle(vehicle_id)
        if section_id not in vehicle.held:
            return False
        if len(vehicle.held) == 1:
            raise ReservationError("holds_nothing", f"{vehicle_id} stands in {section_id} and must keep it")
        number = vehicle.held.index(section_id)
        self.keep(vehicle_id, vehicle.held[:number] + vehicle.held[number + 1 :])
        return True

    def keep(self, vehicle_id: str, held: Sequence[str]) -> None:
        """The vehicle's tail has left the sections that it held besides these."""
        vehicle = self._vehicle(vehicle_id)
        # One that keeps others out of less makes nobody stuck.
        was_safe = self._last_test.is_of(self._claims()) and not self._last_test.stuck
        self._put(vehicle_id, self._entered(vehicle_id, tuple(held), vehicle.ahead, vehicle.goal))
        if was_safe:
            self._last_test.claims = self._claims()

    def blocked_by(self, vehicle_id: str) -> tuple[str, ...]:
        """The vehicle waited for: one that blocks its next section, else one that it would lock in."""
        vehicle = self._vehicle(vehicle_id)
        if not vehicle.ahead:
            return ()
        next_bit = self._ground.bits[vehicle.ahead[0]]
        in_the_way = tuple(
            other_id
            for other_id in self.vehicle_ids
            if other_id != vehicle_id and self._vehicles[other_id].claim.shadow_now & next_bit
        )
        if in_the_way:
            return in_the_way
        stuck = self._ground.stuck(self._claims(vehicle_id, self._moved(vehicle_id, vehicle, 1)))
        if not stuck - self._ground.stuck(self._claims()) and vehicle_id not in stuck:
            return ()
        return tuple(sorted(stuck - {vehicle_id}))

    def _free_count(self, vehicle_id: str, limit: int) -> int:
        """How many sections ahead, at most `limit`, are in no other vehicle's shadow."""
        others = union(
            vehicle.claim.shadow_now for other_id, vehicle in self._vehicles.items() if other_id != vehicle_id
        )
        ahead = self._vehicles[vehicle_id].ahead[: max(0, limit)]
        for count, section_id in enumerate(ahead):
            if self._ground.bits[section_id] & others:
                return count
        return len(ahead)

    def _take_if_safe(self, vehicle_id: str, moved: _Vehicle) -> bool:
        """Move the vehicle on its free way, unless it or another one than before would be stuck.

        Whoever could drive on to where it blocks nobody could have done so from where it came: a possible
        move, which changes nothing of who is stuck (docs/contract/roads.md), so that no test is needed.
        """
        others = [other.claim for other_id, other in self._vehicles.items() if other_id != vehicle_id]
        way = self._ground.free_way(moved.claim, others)
        is_quick = way is FreeWay.TO_THE_END or (
            way is FreeWay.TO_A_PLACE and vehicle_id not in self._stuck_now()
        )
        if is_quick:
            stuck = self._last_test.stuck - {vehicle_id} if self._last_test.is_of(self._claims()) else None
        else:
            stuck = self._ground.stuck(self._claims(vehicle_id, moved))
            if not stuck <= self._stuck_now() - {vehicle_id}:
                return False
        self._put(vehicle_id, moved)
        if stuck is not None:
            self._last_test.claims, self._last_test.stuck = self._claims(), stuck
        return True

    def _put(self, vehicle_id: str, vehicle: _Vehicle) -> None:
        self._vehicles[vehicle_id] = self._restored[vehicle_id] = vehicle

    def _stuck_now(self) -> frozenset[str]:
        """As it is; many requests are refused between two changes."""
        claims = self._claims()
        if not self._last_test.is_of(claims):
            self._last_test.claims, self._last_test.stuck = claims, self._ground.stuck(claims)
        return self._last_test.stuck

    def _claims(self, changed_id: str = "", changed: _Vehicle | None = None) -> list[Claim]:
        return [
            changed.claim
            if changed is not None and vehicle_id == changed_id
            else self._vehicles[vehicle_id].claim
            for vehicle_id in self.vehicle_ids
        ]

    def _entered(
        self, vehicle_id: str, held: tuple[str, ...], ahead: tuple[str, ...], goal: str | None
    ) -> _Vehicle:
        now = self._ground.shadow(held)
        end = now if goal is None else self._ground.shadows[goal]
        is_moving = bool(ahead) or (goal is not None and held != (goal,))
        need, places = self._ground.mask(ahead), self._ground.places(held[-1], ahead)
        return _Vehicle(held, ahead, goal, Claim(vehicle_id, is_moving, places, need, now, end))

    def _moved(self, vehicle_id: str, vehicle: _Vehicle, count: int) -> _Vehicle:
        """The vehicle once it holds `count` sections more."""
        held, ahead = vehicle.held + vehicle.ahead[:count], vehicle.ahead[count:]
        return self._entered(vehicle_id, held, ahead, vehicle.goal)

    def _vehicle(self, vehicle_id: str) -> _Vehicle:
        try:
            return self._vehicles[vehicle_id]
        except KeyError:
            raise ReservationError("unknown_vehicle", f"{vehicle_id} was never placed on the map") from None

    def _check_known(self, section_ids: Iterable[str]) -> None:
        for section_id in section_ids:
            if section_id not in self._ground.bits:
                raise ReservationError("unknown_section", f"the map has no section {section_id}")

    def _next_fence(self) -> int:
        self.last_fence += 1
        return self.last_fence


def _rest_of_route(held: tuple[str, ...], route: Sequence[str]) -> tuple[str, ...] | None:
    """The route after the sections already held; None where the two do not touch."""
    start = next((i for i, section_id in enumerate(route) if section_id in held), None)
    if start is None:
        return None
    best = 0
    for first in range(len(held)):
        match = 0
        while (
            first + match < len(held)
            and start + match < len(route)
            and held[first + match] == route[start + match]
        ):
            match += 1
        best = max(best, match)
    return tuple(route[start + best :])
