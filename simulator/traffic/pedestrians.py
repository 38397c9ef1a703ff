"""Pedestrians around the shuttles of a world."""

import numpy as np

from contract.geometry import Array
from simulator.traffic.actors import Bodies
from simulator.traffic.corridor import SAMPLES, SPACING_M
from simulator.traffic.crowd import RADIUS_M, VEHICLE_COLUMNS, VX, VY, Ints, X, Y, step_crowd
from simulator.traffic.population import Population, TrafficParams
from vehicle_agent.signals import PEDESTRIAN

LIVE_WITHIN_M = 80.0
_POPULATE_EVERY_STEPS = 10
_SPAWN_CLEAR_M = 18.0
_GONE_BEYOND_M = 25.0


class Pedestrians:
    """Steps all pedestrians and keeps the population near the shuttles; deterministic for an rng."""

    def __init__(self, params: TrafficParams, rng: np.random.Generator, vehicle_count: int) -> None:
        self._params, self._rng = params, rng
        self.population = Population(params, rng)
        self._encounter_at_m = [self._stretch(first=True) for _ in range(vehicle_count)]
        self._stroller_at_m = [0.0] * vehicle_count
        self._steps = 0

    @property
    def places(self) -> Array:
        """(n, 2) positions of all pedestrians, map frame."""
        return self.population.people[:, X : Y + 1].copy()

    @property
    def numbers(self) -> Ints:
        """(n,) each pedestrian's number."""
        return self.population.numbers

    def bodies(self) -> Bodies:
        people = self.population.people
        n = len(people)
        velocities = people[:, VX : VY + 1].copy()
        headings = np.arctan2(velocities[:, 1], velocities[:, 0])
        return Bodies(
            self.numbers.copy(),
            np.full(n, PEDESTRIAN, np.int64),
            np.column_stack((self.places, headings)),
            velocities,
            np.full((n, 2), 2.0 * RADIUS_M),
        )

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """One step; vehicles (m, VEHICLE_COLUMNS), odometers_m (m,), ahead (m, SAMPLES, 2)."""
        assert vehicles.shape[1] == VEHICLE_COLUMNS
        if self._steps % _POPULATE_EVERY_STEPS == 0:
            self._populate(vehicles, odometers_m, ahead)
        self._steps += 1
        crowd = self.population
        look_m = -1e9 if self._params.reckless else self._params.look_m
        step_crowd(crowd.people, crowd.activity, crowd.ways, crowd.way, vehicles, ahead, look_m, dt_s)

    def _populate(self, vehicles: Array, odometers_m: Array, ahead: Array) -> None:
        self._remove_distant(vehicles)
        for i in range(len(vehicles)):
            if len(self.places) >= self._params.people_max:
                return
            if odometers_m[i] >= self._encounter_at_m[i] and self._add_encounter(vehicles, ahead[i], i):
                self._encounter_at_m[i] = odometers_m[i] + self._stretch()
            if odometers_m[i] >= self._stroller_at_m[i]:
                self._add_stroller(vehicles, ahead[i], i)
                self._stroller_at_m[i] = odometers_m[i] + 100.0 / max(self._params.strollers_per_100m, 1e-6)

    def _remove_distant(self, vehicles: Array) -> None:
        if not len(self.places):
            return
        if len(vehicles):
            offsets = self.places[:, None, :] - vehicles[None, :, :2]
            nearest_m = np.hypot(offsets[..., 0], offsets[..., 1]).min(axis=1)
        else:
            nearest_m = np.full(len(self.places), np.inf)
        away = nearest_m > np.where(self.population.is_gone(), _GONE_BEYOND_M, LIVE_WITHIN_M)
        if away.any():
            self.population.keep(~away)

    def _add_encounter(self, vehicles: Array, ahead: Array, i: int) -> bool:
        """Add a pedestrian who will enter this shuttle's path; False if the drawn place is not clear."""
        s_m = float(self._rng.uniform(28.0, 0.8 * SPACING_M * SAMPLES))
        chance = float(self._rng.random())
        if not _is_clear(vehicles, ahead, s_m):
            return False
        half_m = float(vehicles[i, 5])
        if chance < 0.65:
            self.population.add_crosser(ahead, s_m, half_m)
        elif chance < 0.85:
            self.population.add_lingerer(ahead, s_m, half_m)
        else:
            self.population.add_walker(ahead, s_m, float(self._rng.uniform(-half_m, half_m)))
        return True

    def _add_stroller(self, vehicles: Array, ahead: Array, i: int) -> None:
        s_m = float(self._rng.uniform(20.0, SPACING_M * (SAMPLES - 4)))
        offset_m = float(vehicles[i, 5]) + float(self._rng.uniform(2.6, 6.0))
        side = 1.0 if self._rng.random() < 0.5 else -1.0
        if _is_clear(vehicles, ahead, s_m):
            self.population.add_walker(ahead, s_m, side * offset_m)

    def _stretch(self, first: bool = False) -> float:
        low, high = self._params.meeting_m
        return float(self._rng.uniform(0.0 if first else low, low if first else high))


def _is_clear(vehicles: Array, ahead: Array, s_m: float) -> bool:
    """No shuttle is so near to the place that a pedestrian would appear in front of it."""
    x, y = ahead[min(round(s_m / SPACING_M), len(ahead) - 1)]
    return bool((np.hypot(vehicles[:, 0] - x, vehicles[:, 1] - y) > _SPAWN_CLEAR_M).all())
