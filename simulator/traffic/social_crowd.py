"""A reactive crowd along a path: its people, their goals and their attention."""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, arc_lengths, pose_at
from simulator.traffic.actors import Bodies, no_bodies
from simulator.traffic.crowd import RADIUS_M, V_SPEED, V_X, V_Y, Ints
from simulator.traffic.social_force import (
    DONE,
    GOAL_X,
    GOAL_Y,
    HEADING,
    LEFT,
    LINGER,
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

_GOALS_EVERY_STEPS = 10
# No person appears within this distance of a shuttle at the start.
_CLEAR_M = 9.0
_STANDING_MPS = 0.3
# Whoever crosses passes the path, so more people are near it than on the rest of the ground: this share more
# for each metre of reach. Measured without a vehicle, with the ratios of `CrowdParams`, from 6 to 16 m.
_NEARER_PATH_1PM = 0.04


@dataclass(frozen=True, slots=True)
class CrowdParams:
    """people_per_100m2  mean on 100 m2 (a circle) about the path, before a vehicle comes
    attentive_ratio      people who make room for a shuttle, and accept gaps or wait
    crossing_ratio, linger_ratio  of all new goals; the others walk along with the flow of their side
    on_path_ratio        of the goals along the path, those on the path itself
    margin_s             of a gap, beyond the time to cross: from, to
    react_s              until a person on the path makes room: from, to
    """

    people_per_100m2: float
    attentive_ratio: float = 0.8
    reach_m: float = 12.0
    crossing_ratio: float = 0.4
    linger_ratio: float = 0.25
    on_path_ratio: float = 0.2
    half_width_m: float = 1.2
    pace_mps: tuple[float, float] = (0.9, 1.6)
    margin_s: tuple[float, float] = (0.5, 2.0)
    react_s: tuple[float, float] = (0.3, 2.0)
    linger_s: tuple[float, float] = (4.0, 20.0)
    people_max: int = 400


class SocialCrowd:
    """Deterministic for a seed; `hold` hides all people until the shuttle starts."""

    def __init__(self, params: CrowdParams, path: Array, seed: int) -> None:
        """path (n, 2): people cross it and walk along it."""
        self.hold = False
        self._params = params
        self._rng = np.random.default_rng([seed, *b"crowd"])
        self._path = np.ascontiguousarray(path, dtype=np.float64)
        self._s = arc_lengths(self._path)
        area_m2 = 2.0 * params.reach_m * float(self._s[-1])
        per_100m2 = params.people_per_100m2 / (1.0 + _NEARER_PATH_1PM * params.reach_m)
        count = min(round(per_100m2 * area_m2 / 100.0), params.people_max)
        self.people: Array = np.zeros((count, PERSON_COLUMNS))
        self.activity: Ints = np.full(count, DONE, np.int64)
        self.attentive: Ints = (self._rng.random(count) < params.attentive_ratio).astype(np.int64)
        self._numbers: Ints = np.arange(1, count + 1)
        self._places = np.empty((count, 2))
        self._waited_s: Array = np.zeros(0)
        self._steps = 0
        for i in range(count):
            self._spawn(i)

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """Vehicles (m, 7), ahead (m, k, 2) as in `traffic.crowd`."""
        if self.hold:
            return
        if self._steps == 0:
            self._clear(vehicles)
        if self._steps % _GOALS_EVERY_STEPS == 0:
            for i in np.flatnonzero(self.activity == DONE):
                self._new_goal(int(i))
        self._steps += 1
        if len(self._waited_s) != len(vehicles):
            self._waited_s = np.zeros(len(vehicles))
        standing = np.abs(vehicles[:, V_SPEED]) < _STANDING_MPS
        self._waited_s = np.where(standing, self._waited_s + dt_s, 0.0)
        step_social(self.people, self.activity, self.attentive, vehicles, ahead, self._waited_s, dt_s)

    def bodies(self) -> Bodies:
        """All people; a person's number never changes."""
        if self.hold:
            return no_bodies()
        people, n = self.people, len(self.people)
        return Bodies(
            self._numbers.copy(),
            np.full(n, PEDESTRIAN, np.int64),
            people[:, [X, Y, HEADING]].copy(),
            people[:, VX : VY + 1].copy(),
            np.full((n, 2), 2.0 * RADIUS_M),
        )

    def _spawn(self, i: int) -> None:
        params, p = self._params, self.people[i]
        s_m, d_m = self._between((0.0, float(self._s[-1]))), self._between((-params.reach_m, params.reach_m))
        p[X], p[Y] = self._at(s_m, d_m)
        self._places[i] = s_m, d_m
        p[HEADING] = self._between((-np.pi, np.pi))
        p[PACE] = self._between(params.pace_mps)
        p[MARGIN] = self._between(params.margin_s)
        p[REACT] = self._between(params.react_s)
        self._new_goal(i)
        if self.activity[i] == WALK:
            # Already walking.
            away = np.array([p[GOAL_X] - p[X], p[GOAL_Y] - p[Y]])
            p[VX : VY + 1] = p[PACE] * away / max(float(np.hypot(*away)), 1e-6)
            p[HEADING] = np.arctan2(p[VY], p[VX])

    def _new_goal(self, i: int) -> None:
        """A goal on the other side, a goal along with the flow, or standing for a while."""
        params, p, length_m = self._params, self.people[i], float(self._s[-1])
        s_m, d_m = self._places[i]
        side = 1.0 if d_m >= 0.0 else -1.0
        chance = float(self._rng.random())
        if chance < params.linger_ratio:
            p[LEFT] = self._between(params.linger_s)
            self.activity[i] = LINGER
            return
        if chance < params.linger_ratio + params.crossing_ratio:
            s_m = float(np.clip(s_m + self._between((-6.0, 6.0)), 0.0, length_m))
            d_m = -side * self._between((params.half_width_m + 1.0, params.reach_m))
        else:
            # Right-hand flow; at the end of the path people turn back on the other side.
            onward_m = -side * self._between((10.0, 35.0))
            if not 0.0 <= s_m + onward_m <= length_m:
                onward_m, side = -onward_m, -side
            s_m = float(np.clip(s_m + onward_m, 0.0, length_m))
            on_path = self._rng.random() < params.on_path_ratio
            beside = (0.0, params.half_width_m) if on_path else (params.half_width_m, params.reach_m)
            d_m = side * self._between(beside)
        self._places[i] = s_m, d_m
        p[GOAL_X], p[GOAL_Y] = self._at(s_m, d_m)
        self.activity[i] = WALK

    def _clear(self, vehicles: Array) -> None:
        """Remove people who would appear beside a shuttle."""
        offsets = self.people[:, None, X : Y + 1] - vehicles[None, :, [V_X, V_Y]]
        far = (np.hypot(offsets[..., 0], offsets[..., 1]) > _CLEAR_M).all(axis=1)
        self.people, self.activity, self.attentive = self.people[far], self.activity[far], self.attentive[far]
        self._numbers, self._places = self._numbers[far], self._places[far]

    def _at(self, s_m: float, d_m: float) -> tuple[float, float]:
        x, y, yaw = pose_at(self._path, self._s, s_m)
        return x - d_m * np.sin(yaw), y + d_m * np.cos(yaw)

    def _between(self, span: tuple[float, float]) -> float:
        return float(self._rng.uniform(*span))
