"""The population of pedestrians: people are added near the roads ahead of the shuttles."""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.traffic.corridor import SPACING_M
from simulator.traffic.crowd import (
    GONE,
    KERB,
    PACE,
    PATIENCE,
    PERSON_COLUMNS,
    STAND,
    TRIGGER,
    WALK,
    WAYPOINTS,
    Ints,
    X,
    Y,
)


@dataclass(frozen=True, slots=True)
class TrafficParams:
    """How many people there are and how they behave.

    meeting_m      distance driven between two people who enter a shuttle's path: from, to
    strollers_per_100m  people walking beside the road ahead
    look_m         people do not step in front of a moving shuttle closer than this to its bumper
    patience_s     how long a shuttle waits until a person on its path leaves it: from, to
    reckless       scenario: people step out without looking
    """

    meeting_m: tuple[float, float] = (32.0, 62.0)
    strollers_per_100m: float = 10.0
    look_m: float = 8.0
    trigger_m: tuple[float, float] = (10.0, 14.0)
    patience_s: tuple[float, float] = (4.0, 8.0)
    pace_mps: tuple[float, float] = (1.0, 1.5)
    people_max: int = 200
    reckless: bool = False


class Population:
    """All pedestrians near a shuttle, as arrays for `crowd.step_crowd`; a person's number never changes."""

    def __init__(self, params: TrafficParams, rng: np.random.Generator) -> None:
        self._params, self._rng = params, rng
        self.people: Array = np.zeros((0, PERSON_COLUMNS))
        self.activity: Ints = np.zeros(0, dtype=np.int64)
        self.ways: Array = np.zeros((0, WAYPOINTS, 2))
        self.way: Ints = np.zeros(0, dtype=np.int64)
        self.numbers: Ints = np.zeros(0, dtype=np.int64)
        self._next_number = 0

    def add_crosser(self, ahead: Array, s_m: float, half_m: float) -> None:
        """Add a person who waits at the kerb and crosses in front of the shuttle when there is room."""
        side = self._side()
        near, far = half_m + self._between(1.5, 2.2), half_m + self._between(2.5, 4.0)
        start = _beside(ahead, s_m, side * near)
        self._add(start, KERB, (_beside(ahead, s_m, -side * far),), self._between(*self._params.trigger_m))

    def add_lingerer(self, ahead: Array, s_m: float, half_m: float) -> None:
        """Add a person who stands in the road until a shuttle has waited for some seconds."""
        self._add(_beside(ahead, s_m, self._between(-half_m, half_m)), STAND, ())

    def add_walker(self, ahead: Array, s_m: float, offset_m: float) -> None:
        """Add a person who walks along the road, in either direction."""
        way = self._side()
        stations = [s_m + way * 6.0 * k for k in range(WAYPOINTS)]
        inside = [s for s in stations if 2.0 <= s <= SPACING_M * (len(ahead) - 2)]
        places = [_beside(ahead, s, offset_m) for s in inside]
        if len(places) > 1:
            self._add(places[0], WALK, tuple(places[1:]))

    def place(self, x_m: float, y_m: float, waypoints: tuple[tuple[float, float], ...] = ()) -> int:
        """Scenario: one person at a place of the map; returns the person's number."""
        self._add((x_m, y_m), WALK if waypoints else STAND, waypoints)
        return int(self.numbers[-1])

    def keep(self, mask: np.ndarray) -> None:
        """Remove the people where mask (n,) is False."""
        self.people, self.activity = self.people[mask], self.activity[mask]
        self.ways, self.way, self.numbers = self.ways[mask], self.way[mask], self.numbers[mask]

    def is_gone(self) -> np.ndarray:
        """(n,) which people have reached their last waypoint."""
        gone: np.ndarray = self.activity == GONE
        return gone

    def _add(
        self,
        start: tuple[float, float],
        activity: int,
        waypoints: tuple[tuple[float, float], ...],
        trigger_m: float = 0.0,
    ) -> None:
        person = np.zeros((1, PERSON_COLUMNS))
        person[0, X], person[0, Y] = start
        person[0, PACE] = self._between(*self._params.pace_mps)
        person[0, PATIENCE] = self._between(*self._params.patience_s)
        person[0, TRIGGER] = trigger_m
        route = np.full((1, WAYPOINTS, 2), np.nan)
        for k, place in enumerate(waypoints[:WAYPOINTS]):
            route[0, k] = place
        self.people = np.concatenate([self.people, person])
        self.activity = np.append(self.activity, activity)
        self.ways = np.concatenate([self.ways, route])
        self.way = np.append(self.way, 0)
        self.numbers = np.append(self.numbers, self._next_number)
        self._next_number += 1

    def _side(self) -> float:
        return 1.0 if self._rng.random() < 0.5 else -1.0

    def _between(self, low: float, high: float) -> float:
        return float(self._rng.uniform(low, high))


def _beside(ahead: Array, s_m: float, offset_m: float) -> tuple[float, float]:
    """The place offset_m to the left of the corridor at s_m."""
    k = min(max(round(s_m / SPACING_M), 1), len(ahead) - 2)
    tangent = ahead[k + 1] - ahead[k - 1]
    tangent = tangent / np.hypot(*tangent)
    return float(ahead[k, 0] - offset_m * tangent[1]), float(ahead[k, 1] + offset_m * tangent[0])
