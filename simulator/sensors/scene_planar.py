"""The planar scanner of one vehicle in a world's scene, tick by tick."""

from collections.abc import Callable

import numpy as np

from contract.geometry import Pose2, wrap_angle
from simulator.sensors.lidars.driver import planar_points
from simulator.sensors.lidars.faults import FaultyPlanarScanner
from simulator.sensors.lidars.firings import Array32
from simulator.sensors.lidars.mounts import planar_mount
from simulator.sensors.lidars.planar_scanner import PlanarScanner
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Profile

# What wheels and gyroscope add to the motion by which the driver puts a turn's points together.
_SPEED_STD_MPS, _YAW_RATE_STD_RADPS = 0.02, 0.003


class VehiclePlanarScanner:
    """Scans at the profile's rate; a turn of the mirror is over within the 20 ms of one step.

    scanner  whose fault may be set
    """

    def __init__(
        self, scene: StaticScene, profile: Profile, rng: np.random.Generator, rain_mm_per_h: float = 0.0
    ) -> None:
        body, params = profile.body, profile.planar_scanner
        own = CastScene(shuttle(body.length_m, body.width_m, body.height_m, body.rear_overhang_m))
        self._mount = planar_mount(params)
        self.scanner = FaultyPlanarScanner(
            PlanarScanner(
                self._mount, scene, np.random.default_rng(rng.integers(1 << 62)), own, rain_mm_per_h
            )
        )
        self._ground, self._wheelbase_m, self._rng = scene.ground, body.wheelbase_m, rng
        self._every_ns = round(1e9 / params.rate_hz)
        self._turn_ns = round(1e9 / params.mirror_hz)
        self._before: tuple[int, Pose2] | None = None
        self._due_ns: int | None = None

    def step(
        self, now_ns: int, truth: PlantView, moving_now: Callable[[], MovingBodies] | None = None
    ) -> tuple[Array32, Array32] | None:
        """Points (n, 3) base frame at now_ns and intensities (n,) of the turn that ends now, if it is due.

        moving_now  what moves around; it is asked for a turn that is due. None: nothing does
        """
        before, self._before = self._before, (now_ns, truth.pose_map)
        due_ns = now_ns if self._due_ns is None else self._due_ns
        if before is None or now_ns < due_ns:
            return None
        self._due_ns = due_ns + self._every_ns
        begin_ns = now_ns - self._turn_ns
        way = _Way(before, (now_ns, truth.pose_map))

        def trajectory(times_ns: np.ndarray) -> np.ndarray:
            return self._ground.poses(way.poses(times_ns), self._wheelbase_m)

        scan = self.scanner.scan(trajectory, begin_ns, () if moving_now is None else (moving_now(),))
        if scan is None:
            return None
        speed, yaw_rate = self._rng.standard_normal(2).tolist()
        speed = truth.speed_mps * truth.wheel_ratio + _SPEED_STD_MPS * speed * (truth.speed_mps != 0.0)
        yaw_rate = truth.yaw_rate_radps + _YAW_RATE_STD_RADPS * yaw_rate
        return planar_points(scan, self._mount.T_base_sensor, self._turn_ns, speed, yaw_rate)


class _Way:
    """Between two poses the vehicle moves evenly."""

    def __init__(self, first: tuple[int, Pose2], last: tuple[int, Pose2]) -> None:
        self._times = np.array([first[0], last[0]], dtype=np.float64)
        turn_rad = wrap_angle(last[1].yaw_rad - first[1].yaw_rad)
        self._rows = np.array(
            [
                [first[1].x_m, first[1].y_m, first[1].yaw_rad],
                [last[1].x_m, last[1].y_m, first[1].yaw_rad + turn_rad],
            ]
        )

    def poses(self, times_ns: np.ndarray) -> np.ndarray:
        """(n, 3) x, y, yaw at times (n,), ns."""
        return np.column_stack([np.interp(times_ns, self._times, column) for column in self._rows.T])
