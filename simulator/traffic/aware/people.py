"""Recorded people who heed a vehicle: on their recorded ways, as they heeded the recorded car."""

from collections.abc import Sequence

import numpy as np

from contract.geometry import Array, BoolArray
from simulator.traffic.actors import Bodies, no_bodies
from simulator.traffic.aware.conflict import clearance_m
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.reaction import (
    OFFSET_X,
    OFFSET_Y,
    OWN_S,
    PACE,
    STATE_COLUMNS,
    TARGET_PACE,
    step_people,
)
from simulator.traffic.aware.ways import WAY_STEP_S, OwnWays, places_at
from simulator.traffic.crowd import V_SPEED, V_YAW
from simulator.traffic.recordings import PERSON_SIZE_M
from simulator.traffic.replayed import AFTERWARDS_S
from vehicle_agent.signals import PEDESTRIAN

# People look again this often.
DECISION_S = 0.2
# The time constant with which they see how a vehicle turns and brakes.
SEEING_S = 0.3
_AT_ONCE_S = 1e-6


class AwarePeople:
    """People on their own ways who heed the vehicles that they are shown.

    delayed   numbers of people who entered later than recorded, because a vehicle stood in their place
    """

    def __init__(
        self,
        numbers: Sequence[int],
        ways: OwnWays,
        limits: Array,
        params: ReactionParams,
        from_s: float,
        ends_s: float,
    ) -> None:
        """limits (n, 2): each person's margin_m and notice_s; ends_s: the end of the recording."""
        self.clock_s = from_s
        self.delayed: set[int] = set()
        self._numbers = np.array(numbers, dtype=np.int64)
        self._ways, self._limits, self._row = ways, limits, params.row()
        self.state = np.zeros((len(numbers), STATE_COLUMNS))
        self.state[:, OWN_S] = np.maximum(from_s, ways.begins_s)
        self.state[:, PACE] = self.state[:, TARGET_PACE] = 1.0
        self._own_ends_s = ways.begins_s + WAY_STEP_S * (ways.count - 1)
        lasts = self._own_ends_s >= ends_s - 0.1
        self._leaves_s = np.where(lasts, self._own_ends_s + AFTERWARDS_S, self._own_ends_s)
        self._entered = ways.begins_s <= from_s + _AT_ONCE_S
        self._look_again_s = from_s
        self._seen: Array | None = None
        self._motions = np.zeros((0, 2))
        self._places = self._all_places()
        # Until they have moved, as on their first tenth of a second.
        self._velocities = (self._all_places(0.1) - self._places) / 0.1

    @property
    def present(self) -> BoolArray:
        """(n,) who is in the scene."""
        there: BoolArray = self._entered & (self.state[:, OWN_S] <= self._leaves_s + _AT_ONCE_S)
        return there

    def step(self, vehicles: Array, dt_s: float) -> None:
        """Move everyone by dt_s; vehicles (m, 7) as in `traffic.crowd`."""
        self.clock_s += dt_s
        self._enter(vehicles, dt_s)
        self._watch(vehicles, dt_s)
        decide = self.clock_s >= self._look_again_s - _AT_ONCE_S
        if decide:
            self._look_again_s += DECISION_S
        ways, before = self._ways, self._places
        step_people(
            self.state, self.present, ways.places, ways.first, ways.count, ways.begins_s, ways.ends_mps,
            self._limits, self._row, vehicles, self._motions, decide, dt_s,
        )  # fmt: skip
        self._places = self._all_places()
        share = min(1.0, dt_s / 0.1)
        self._velocities += share * ((self._places - before) / dt_s - self._velocities)

    def _enter(self, vehicles: Array, dt_s: float) -> None:
        """People enter when recorded, but not into a body: they wait outside the picture until it is gone."""
        for i in np.flatnonzero(~self._entered & (self._ways.begins_s <= self.clock_s + _AT_ONCE_S)):
            x, y = self._ways.places[self._ways.first[i]]
            if all(clearance_m(x, y, row[:3], row) > self._limits[i, 0] for row in vehicles):
                self._entered[i] = True
                if int(self._numbers[i]) not in self.delayed:
                    self.state[i, OWN_S] = self.clock_s - dt_s
            else:
                self.delayed.add(int(self._numbers[i]))

    def _watch(self, vehicles: Array, dt_s: float) -> None:
        """How the vehicles turn and brake, smoothed."""
        if self._seen is None or len(self._seen) != len(vehicles):
            self._motions = np.zeros((len(vehicles), 2))
        else:
            turned = (vehicles[:, V_YAW] - self._seen[:, V_YAW] + np.pi) % (2.0 * np.pi) - np.pi
            now = np.column_stack((turned, vehicles[:, V_SPEED] - self._seen[:, V_SPEED])) / dt_s
            self._motions += min(1.0, dt_s / SEEING_S) * (now - self._motions)
        self._seen = vehicles.copy()

    def _all_places(self, ahead_s: float = 0.0) -> Array:
        ways = self._ways
        out: Array = places_at(
            ways.places, ways.first, ways.count, ways.begins_s, ways.ends_mps, self.state[:, OWN_S] + ahead_s
        )
        return out + self.state[:, OFFSET_X : OFFSET_Y + 1]

    @property
    def places(self) -> Array:
        """(n, 2) of all, also of those who are not in the scene."""
        return self._places

    def bodies(self) -> Bodies:
        """Everyone who is in the scene."""
        there = self.present
        if not there.any():
            return no_bodies()
        velocities = self._velocities[there]
        yaws = np.arctan2(velocities[:, 1], velocities[:, 0])
        count = int(there.sum())
        return Bodies(
            self._numbers[there],
            np.full(count, PEDESTRIAN, dtype=np.int64),
            np.column_stack((self._places[there], yaws)),
            velocities,
            np.full((count, 2), PERSON_SIZE_M),
        )
