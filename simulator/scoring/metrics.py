"""The score of each vehicle, by ground truth."""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from contract.geometry import Array
from contract.roads.model import Building
from contract.roads.walls import wall_edges
from simulator.traffic.corridor import place_in_corridor
from simulator.traffic.crowd import RADIUS_M, V_FRONT, V_HALF, V_X, V_Y, Ints, clearance_m
from simulator.traffic.outlines import outline_meets_edges, outlines_overlap
from simulator.vehicle.plant import PlantView

ENCOUNTER_AHEAD_M = 15.0
_STOPPED_MPS = 0.05
_UNDER_WAY_NS = 10_000_000_000
_WAITS_FOR_AHEAD_M = 8.0
_WAITS_FOR_BESIDE_M = 1.2
_APART_M = 0.3
_LEFT_BESIDE_M = 2.0
_LEFT_AHEAD_M = 20.0
_BUILDINGS_EVERY_STEPS = 10


@dataclass(slots=True)
class VehicleScore:
    """One vehicle's score so far.

    contacts_*        contacts of its outline with a person's disc (0.25 m), another shuttle, a building
    encounters        people in its swept path within 15 m of the bumper, once per approach
    stopped_for_people_s  time for which it stood with a person on its path or beside it
    clearance_m_min   least distance from its outline to a person while it moved
    """

    distance_m: float = 0.0
    contacts_people: int = 0
    contacts_vehicles: int = 0
    contacts_buildings: int = 0
    encounters: int = 0
    stopped_for_people_s: float = 0.0
    hardest_braking_mps2: float = 0.0
    speed_mps_max: float = 0.0
    clearance_m_min: float = math.inf

    @property
    def contacts(self) -> int:
        return self.contacts_people + self.contacts_vehicles + self.contacts_buildings


@dataclass(slots=True)
class _ScoreState:
    """The present contacts and approaches of one vehicle, so that each counts once."""

    touching: set[int] = field(default_factory=set)
    touching_vehicles: set[int] = field(default_factory=set)
    in_building: bool = False
    approached: set[int] = field(default_factory=set)
    moved_ns: int = -_UNDER_WAY_NS
    speed_mps: float = 0.0


class Scorekeeper:
    """Scores all vehicles, in the order given to `step`."""

    def __init__(self, vehicle_ids: tuple[str, ...], buildings: tuple[Building, ...]) -> None:
        self.scores = {vehicle_id: VehicleScore() for vehicle_id in vehicle_ids}
        self._states = [_ScoreState() for _ in vehicle_ids]
        self._edges = wall_edges(buildings)
        self._steps = 0

    def step(
        self,
        now_ns: int,
        dt_s: float,
        views: list[PlantView],
        vehicles: Array,
        ahead: Array,
        places: Array,
        numbers: Ints,
    ) -> None:
        """Score one step; vehicles (m, 7) and ahead (m, k, 2) as in `traffic.crowd`, places (n, 2)."""
        self._steps += 1
        for i, (score, state) in enumerate(zip(self.scores.values(), self._states, strict=True)):
            view = views[i]
            score.distance_m = view.odometer_m
            score.speed_mps_max = max(score.speed_mps_max, abs(view.speed_mps))
            braking = (abs(state.speed_mps) - abs(view.speed_mps)) / dt_s
            score.hardest_braking_mps2 = max(score.hardest_braking_mps2, braking)
            state.speed_mps = view.speed_mps
            if abs(view.speed_mps) > _STOPPED_MPS:
                state.moved_ns = now_ns
            if len(places):
                near = relations(vehicles[i], ahead[i], places)
                _score_people(score, state, near, numbers, now_ns, dt_s, float(vehicles[i, V_HALF]))
            _score_vehicles(score, state, vehicles, i)
            if self._steps % _BUILDINGS_EVERY_STEPS == 0:
                _score_buildings(score, state, vehicles[i], self._edges)


def _score_people(
    score: VehicleScore,
    state: _ScoreState,
    near: Array,
    numbers: Ints,
    now_ns: int,
    dt_s: float,
    half_m: float,
) -> None:
    """near (n, 3): clearance, gap along the corridor from the bumper, offset beside it."""
    clearance, gap, off = near[:, 0], near[:, 1], near[:, 2]
    moving = now_ns == state.moved_ns
    if moving:
        score.clearance_m_min = min(score.clearance_m_min, float(clearance.min()) - RADIUS_M)
    touching = set(numbers[clearance <= RADIUS_M].tolist())
    score.contacts_people += len(touching - state.touching)
    state.touching = touching | (state.touching & set(numbers[clearance <= RADIUS_M + _APART_M].tolist()))
    inside = (off <= half_m + RADIUS_M) & (gap >= 0.0) & (gap <= ENCOUNTER_AHEAD_M)
    still_near = (off <= half_m + _LEFT_BESIDE_M) & (gap >= -1.0) & (gap <= _LEFT_AHEAD_M)
    state.approached &= set(numbers[still_near].tolist())
    if now_ns - state.moved_ns < _UNDER_WAY_NS:
        met = set(numbers[inside].tolist())
        score.encounters += len(met - state.approached)
        state.approached |= met
    waits = (off <= half_m + _WAITS_FOR_BESIDE_M) & (gap >= -0.5) & (gap <= _WAITS_FOR_AHEAD_M)
    if not moving and waits.any():
        score.stopped_for_people_s += dt_s


def _score_vehicles(score: VehicleScore, state: _ScoreState, vehicles: Array, i: int) -> None:
    touching = {j for j in range(len(vehicles)) if j != i and outlines_overlap(vehicles[i], vehicles[j])}
    score.contacts_vehicles += len(touching - state.touching_vehicles)
    state.touching_vehicles = touching


def _score_buildings(score: VehicleScore, state: _ScoreState, vehicle: Array, edges: Array) -> None:
    inside = bool(outline_meets_edges(vehicle, edges))
    score.contacts_buildings += inside and not state.in_building
    state.in_building = inside


@njit(cache=True)
def relations(vehicle: Array, ahead: Array, places: Array) -> Array:
    """(n, 3) for each person: clearance to the outline, gap from the bumper along the corridor, offset.

    People further than 40 m get infinite values.
    """
    n = places.shape[0]
    out = np.full((n, 3), np.inf)
    for i in range(n):
        x, y = places[i, 0], places[i, 1]
        if math.hypot(x - vehicle[V_X], y - vehicle[V_Y]) > 40.0:
            continue
        s, d, _, _ = place_in_corridor(ahead, x, y)
        out[i, 0] = clearance_m(vehicle, x, y)
        out[i, 1] = s - vehicle[V_FRONT]
        out[i, 2] = abs(d)
    return out
