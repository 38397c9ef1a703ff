"""People who come out of doors, at the break of a lecture for instance, and go their ways."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.traffic.actors import Bodies, no_bodies
from simulator.traffic.crowd import RADIUS_M, V_SPEED, Ints, clearance_m
from simulator.traffic.social_force import (
    DONE,
    GOAL_X,
    GOAL_Y,
    HEADING,
    MARGIN,
    PACE,
    PERSON_COLUMNS,
    REACT,
    VX,
    VY,
    WALK,
    X,
    Y,
    step_social,
)
from vehicle_agent.signals import PEDESTRIAN

# A door is free when nobody stands this near to where the next person comes out, and no vehicle.
_FREE_M = 0.6
_VEHICLE_FREE_M = 1.0
# People's own places about a goal.
_SPREAD_M = 1.0
# Who is this near to the goal has arrived.
_ARRIVED_M = 0.8
_STANDING_MPS = 0.3


@dataclass(frozen=True, slots=True)
class Door:
    """at: middle of the door; heading_rad: outward. From from_s on, people_per_s until `people` are out.

    goals (k, 2)     where they go, each one to any
    attentive_ratio  of people who heed a shuttle
    """

    at: tuple[float, float]
    heading_rad: float
    width_m: float
    people: int
    people_per_s: float
    goals: Array
    from_s: float = 0.0
    attentive_ratio: float = 0.8
    pace_mps: tuple[float, float] = (0.9, 1.6)
    margin_s: tuple[float, float] = (0.5, 2.0)
    react_s: tuple[float, float] = (0.3, 2.0)


class DoorCrowd:
    """Deterministic for a seed. `hold` stops the clock and hides all; people are gone at their goals."""

    def __init__(self, doors: tuple[Door, ...], seed: int) -> None:
        self.hold = False
        self._doors = doors
        self._rng = np.random.default_rng([seed, *b"doors"])
        self._clock_s = 0.0
        self._out = [0] * len(doors)
        self._next_s = [door.from_s for door in doors]
        self.people: Array = np.zeros((0, PERSON_COLUMNS))
        self.attentive: Ints = np.zeros(0, np.int64)
        self._activity: Ints = np.zeros(0, np.int64)
        self._door_of: Ints = np.zeros(0, np.int64)
        self._numbers: Ints = np.zeros(0, np.int64)
        self._waited_s: Array = np.zeros(0)

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """Vehicles (m, 7), ahead (m, k, 2) as in `traffic.crowd`."""
        if self.hold:
            return
        self._clock_s += dt_s
        for number, door in enumerate(self._doors):
            if self._out[number] < door.people and self._clock_s >= self._next_s[number]:
                self._let_out(number, door, vehicles)
        self._end_walks()
        if len(self._waited_s) != len(vehicles):
            self._waited_s = np.zeros(len(vehicles))
        standing = np.abs(vehicles[:, V_SPEED]) < _STANDING_MPS
        self._waited_s = np.where(standing, self._waited_s + dt_s, 0.0)
        step_social(self.people, self._activity, self.attentive, vehicles, ahead, self._waited_s, dt_s)

    def bodies(self) -> Bodies:
        """All who are out now, numbered in the order in which they came out."""
        if self.hold or not len(self.people):
            return no_bodies()
        people, n = self.people, len(self.people)
        return Bodies(
            self._numbers.copy(),
            np.full(n, PEDESTRIAN, np.int64),
            people[:, [X, Y, HEADING]].copy(),
            people[:, VX : VY + 1].copy(),
            np.full((n, 2), 2.0 * RADIUS_M),
        )

    def _let_out(self, number: int, door: Door, vehicles: Array) -> None:
        """One person comes out, if there is room."""
        aside_m = float(self._rng.uniform(-0.5, 0.5)) * door.width_m
        x = door.at[0] - aside_m * math.sin(door.heading_rad)
        y = door.at[1] + aside_m * math.cos(door.heading_rad)
        taken = np.hypot(self.people[:, X] - x, self.people[:, Y] - y) < _FREE_M
        if taken.any() or any(clearance_m(vehicle, x, y) < _VEHICLE_FREE_M for vehicle in vehicles):
            return
        p = np.zeros(PERSON_COLUMNS)
        p[X], p[Y], p[HEADING] = x, y, door.heading_rad
        p[PACE] = self._rng.uniform(*door.pace_mps)
        p[MARGIN] = self._rng.uniform(*door.margin_s)
        p[REACT] = self._rng.uniform(*door.react_s)
        p[VX], p[VY] = p[PACE] * math.cos(door.heading_rad), p[PACE] * math.sin(door.heading_rad)
        self._choose_goal(p, door)
        self.people = np.vstack((self.people, p))
        heeds = int(self._rng.random() < door.attentive_ratio)
        self.attentive = np.append(self.attentive, heeds)
        self._activity = np.append(self._activity, WALK)
        self._door_of = np.append(self._door_of, number)
        self._numbers = np.append(self._numbers, sum(self._out) + 1)
        self._out[number] += 1
        # About evenly: two never come out at once, and no gap is longer than two.
        self._next_s[number] = self._clock_s + float(self._rng.uniform(0.5, 1.5)) / door.people_per_s

    def _choose_goal(self, p: Array, door: Door) -> None:
        goal = door.goals[int(self._rng.integers(len(door.goals)))]
        p[GOAL_X : GOAL_Y + 1] = goal + self._rng.uniform(-_SPREAD_M, _SPREAD_M, 2)

    def _end_walks(self) -> None:
        """Who has arrived is gone; who cannot, because a vehicle stands on the goal, takes another one."""
        done = self._activity == DONE
        if not done.any():
            return
        to_go = np.hypot(
            self.people[:, GOAL_X] - self.people[:, X], self.people[:, GOAL_Y] - self.people[:, Y]
        )
        for i in np.flatnonzero(done & (to_go > _ARRIVED_M)):
            self._choose_goal(self.people[i], self._doors[int(self._door_of[i])])
            self._activity[i] = WALK
        stay = ~(done & (to_go <= _ARRIVED_M))
        self.people, self.attentive = self.people[stay], self.attentive[stay]
        self._activity, self._door_of = self._activity[stay], self._door_of[stay]
        self._numbers = self._numbers[stay]
