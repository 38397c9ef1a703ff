"""A spinning lidar on a vehicle that moves while it scans."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.sensors.lidars.firings import Array32, turn_of
from simulator.sensors.lidars.response import LidarResponse, response_of, response_row
from simulator.sensors.lidars.returns import pack
from simulator.sensors.lidars.scanner import MovingBodies, Scanner, Trajectory, Turn
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from vehicle_agent.lidar.models import XT16, LidarModel
from vehicle_agent.signals.point_cloud import PointCloud


@dataclass(frozen=True, slots=True, eq=False)
class MountedLidar:
    """One lidar and its place.

    T_base_sensor  (4, 4); the sensor's frame is that of its maker, as in `PointCloud`
    response       None for that of the maker's datasheet
    """

    name: str
    T_base_sensor: Array
    model: LidarModel = XT16
    rate_hz: float = 10.0
    response: LidarResponse | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LidarScan:
    """One turn.

    cloud        as decoded from the sensor's packets: distorted by the motion during the turn
    points_base  (n, 3) the same points by T_base_sensor
    ghosts       how many of them are bloom beside a retro-reflector
    """

    cloud: PointCloud
    points_base: Array32
    ghosts: int = 0


class SpinningLidar:
    """One sensor of one vehicle; the same generator state and poses give the same bytes."""

    def __init__(
        self,
        mounted: MountedLidar,
        scene: StaticScene,
        rng: np.random.Generator,
        own_body: CastScene | None = None,
        rain_mm_per_h: float = 0.0,
    ) -> None:
        """own_body: the vehicle itself in its base frame; its returns are in every scan."""
        self.mounted = mounted
        self.period_ns = round(1e9 / mounted.rate_hz)
        model = mounted.model
        response = mounted.response or response_of(model)
        limits_m = (model.range_m_min, model.range_m_max)
        params = response_row(response, limits_m, rain_mm_per_h, scene.changes.sway_m)
        turn = Turn(*turn_of(model, mounted.rate_hz), model.channels)
        self._scanner = Scanner(turn, mounted.T_base_sensor, params, scene, rng, own_body)
        self._mount = mounted.T_base_sensor[:3].astype(np.float32)

    @property
    def rays(self) -> int:
        """Firings of a turn that the own body does not stop."""
        return self._scanner.rays

    def scan(self, trajectory: Trajectory, begin_ns: int, moving: Sequence[MovingBodies] = ()) -> LidarScan:
        """The turn that begins at begin_ns.

        trajectory  T_map_base (n, 4, 4) at times (n,) int64, ns; asked until a little after the turn's end
        moving      in order of time; the last one is valid to the end of the turn
        """
        turn = self._scanner.turn
        returns = self._scanner.measure(trajectory, begin_ns, moving, self.mounted.model.range_m_max)
        points, based, values, rings, times_ns = pack(
            returns.ranges, returns.intensities, turn.directions, turn.offsets_ns, turn.rings, self._mount
        )
        return LidarScan(PointCloud(begin_ns, points, values, rings, times_ns), based, returns.ghosts)
