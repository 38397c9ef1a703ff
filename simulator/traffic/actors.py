"""Road users around the vehicles of a world."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.ray_hits import BOX_COLUMNS
from vehicle_agent.signals import PEDESTRIAN

Ints = NDArray[np.int64]
PERSON_HEIGHT_M = 1.7
VEHICLE_HEIGHT_M = 1.6


@dataclass(frozen=True, slots=True)
class Bodies:
    """The road users at one moment, map frame.

    numbers (n,) constant for each road user; kinds (n,) as in `signals.TRACK_KINDS`
    poses_map (n, 3) middle of the outline; velocities_map_mps (n, 2)
    sizes_m (n, 2) length and width; a person is a disc of that diameter
    """

    numbers: Ints
    kinds: Ints
    poses_map: Array
    velocities_map_mps: Array
    sizes_m: Array

    def selected(self, chosen: NDArray[np.bool_]) -> "Bodies":
        """Those that `chosen` (n,) names."""
        return Bodies(
            self.numbers[chosen], self.kinds[chosen], self.poses_map[chosen],
            self.velocities_map_mps[chosen], self.sizes_m[chosen],
        )  # fmt: skip

    @property
    def people(self) -> NDArray[np.bool_]:
        """(n,) which of them are pedestrians."""
        on_foot: NDArray[np.bool_] = self.kinds == PEDESTRIAN
        return on_foot

    def cylinders(self) -> Array:
        """(k, 4) the people for the lidar: x, y, radius, height."""
        people = self.people
        out = np.empty((int(people.sum()), 4))
        out[:, :2] = self.poses_map[people, :2]
        out[:, 2] = 0.5 * self.sizes_m[people, 0]
        out[:, 3] = PERSON_HEIGHT_M
        return out

    def boxes(self) -> Array:
        """(k, 7) all others for the lidar: x, y, yaw, rear, front, half width, height."""
        driven = ~self.people
        out = np.empty((int(driven.sum()), BOX_COLUMNS))
        out[:, :3] = self.poses_map[driven]
        out[:, 3] = out[:, 4] = 0.5 * self.sizes_m[driven, 0]
        out[:, 5] = 0.5 * self.sizes_m[driven, 1]
        out[:, 6] = VEHICLE_HEIGHT_M
        return out


def no_bodies() -> Bodies:
    """An empty set of bodies."""
    none = np.zeros(0, np.int64)
    return Bodies(none, none, np.zeros((0, 3)), np.zeros((0, 2)), np.zeros((0, 2)))


def together(*groups: Bodies) -> Bodies:
    """All groups as one; their numbers must differ."""
    return Bodies(
        np.concatenate([g.numbers for g in groups]),
        np.concatenate([g.kinds for g in groups]),
        np.concatenate([g.poses_map for g in groups]),
        np.concatenate([g.velocities_map_mps for g in groups]),
        np.concatenate([g.sizes_m for g in groups]),
    )


class Actors(Protocol):
    """Stepped with the world, after the vehicles."""

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """One step; vehicles (m, 7) as in `traffic.crowd`, odometers_m (m,), ahead (m, SAMPLES, 2)."""
        ...

    def bodies(self) -> Bodies:
        """All bodies after the last step."""
        ...
