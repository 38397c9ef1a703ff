"""The part of a lidar's turn that looks ahead: where signs are looked for, in a third of the time."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from contract.geometry import Array
from simulator.sensors.lidars.firings import turn_of
from simulator.sensors.lidars.response import response_of, response_row
from simulator.sensors.lidars.returns import pack
from simulator.sensors.lidars.scanner import Scanner, Turn
from simulator.sensors.lidars.spinning_lidar import MountedLidar
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from vehicle_agent.lidar.models import VLP16, XT16, LidarModel

MODELS: dict[str, LidarModel] = {"VLP-16": VLP16, "XT16": XT16}
_HALF_FIELD_RAD = math.radians(65.0)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class FrontScan:
    """points_base (n, 3), intensities (n,), offsets_ns (n,) after the turn's begin."""

    points_base: Array
    intensities: Array
    offsets_ns: Array


class FrontLidar:
    """One lidar that returns only what lies within 65 degrees of straight ahead."""

    def __init__(
        self, mounted: MountedLidar, scene: StaticScene, rng: np.random.Generator, own_body: CastScene
    ) -> None:
        model = mounted.model
        directions, offsets_ns, rings = turn_of(model, mounted.rate_hz)
        ahead = directions @ mounted.T_base_sensor[:3, :3].T
        # Whole columns of firings, so that bloom has its neighbours.
        columns = ahead.reshape(-1, model.channels, 3).mean(axis=1)
        kept = np.repeat(np.abs(np.arctan2(columns[:, 1], columns[:, 0])) <= _HALF_FIELD_RAD, model.channels)
        self._turn = Turn(
            np.ascontiguousarray(directions[kept]), offsets_ns[kept], rings[kept], model.channels
        )
        params = response_row(
            response_of(model), (model.range_m_min, model.range_m_max), 0.0, scene.changes.sway_m
        )
        self._scanner = Scanner(self._turn, mounted.T_base_sensor, params, scene, rng, own_body)
        self._mount = mounted.T_base_sensor[:3].astype(np.float32)
        self._range_m_max = model.range_m_max

    def scan(self, trajectory: Callable[[np.ndarray], Array], begin_ns: int) -> FrontScan:
        """As `SpinningLidar.scan`, without what moves."""
        turn = self._turn
        returns = self._scanner.measure(trajectory, begin_ns, (), self._range_m_max)
        _, based, values, _, times_ns = pack(
            returns.ranges, returns.intensities, turn.directions, turn.offsets_ns, turn.rings, self._mount
        )
        return FrontScan(based, values, times_ns)
