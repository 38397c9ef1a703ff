"""How many people a vehicle has around it as it drives, and its speed among them, by ground truth."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, BoolArray
from simulator.traffic.actors import Bodies
from vehicle_agent.config import Body
from vehicle_agent.signals import PEDESTRIAN

DENSE_MET = (5, 8)
_RADIUS_M = math.sqrt(100.0 / math.pi)
_EVERY_S = 0.5


@dataclass(frozen=True, slots=True)
class PeopleMet:
    """Moments of a drive, half a second apart.

    people     (n,) how many are on the 100 m2 about the middle of the bumper
    speed_mps  (n,) of the vehicle, at the same moments
    """

    people: Array
    speed_mps: Array

    @property
    def per_100m2(self) -> float:
        """Mean of the drive; the body takes some of the 100 m2."""
        return float(self.people.mean()) if len(self.people) else 0.0

    @property
    def dense_s(self) -> float:
        """How long there were 5 to 8."""
        return _EVERY_S * float(self._is_dense.sum())

    @property
    def dense_m(self) -> float:
        """How far the vehicle drove in that time."""
        return _EVERY_S * float(self.speed_mps[self._is_dense].sum())

    @property
    def _is_dense(self) -> BoolArray:
        fewest, most = DENSE_MET
        dense: BoolArray = (self.people >= fewest) & (self.people <= most)
        return dense


def people_met(rows: Array, agents: list[Bodies], body: Body) -> PeopleMet:
    """rows (n, 7): `trace.VEHICLE_COLUMNS`; agents: at the same times."""
    if not len(rows):
        return PeopleMet(np.zeros(0), np.zeros(0))
    times_s = rows[:, 0]
    moments = np.searchsorted(times_s, np.arange(times_s[0], times_s[-1] + 1e-9, _EVERY_S) - 1e-6)
    people = []
    for row, bodies in zip(rows[moments], (agents[k] for k in moments), strict=True):
        x_m, y_m, yaw_rad = row[1:4]
        ahead_m = body.front_overhang_m
        bumper = (x_m + ahead_m * math.cos(yaw_rad), y_m + ahead_m * math.sin(yaw_rad))
        places = bodies.poses_map[bodies.kinds == PEDESTRIAN, :2]
        people.append(float((np.hypot(*(places - bumper).T) < _RADIUS_M).sum()))
    return PeopleMet(np.array(people), np.abs(rows[moments, 4]))
