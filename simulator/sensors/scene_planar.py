"""The planar scanner of one vehicle in a world's scene, tick by tick."""

from collections import deque
from collections.abc import Callable, Iterable

import numpy as np

from contract.geometry import Pose2
from simulator.sensors.lidars.driver import planar_points
from simulator.sensors.lidars.faults import FaultyPlanarScanner
from simulator.sensors.lidars.firings import Array32
from simulator.sensors.lidars.mounts import planar_mount
from simulator.sensors.lidars.planar_scanner import PlanarScanner
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import PlanarScanner as PlanarScannerProfile
from vehicle_agent.config import Profile

# What wheels and gyroscope add to the motion by which the driver puts a turn's points together.
_SPEED_STD_MPS, _YAW_RATE_STD_RADPS = 0.02, 0.003


class VehiclePlanarScanner:
    """Scans at the profile's rate; each beam leaves from where the vehicle was in its turn of the mirror.

    scanner  whose fault may be set
    """

    def __init__(
        self,
        scene: StaticScene,
        profile: Profile,
        rng: np.random.Generator,
        rain_mm_per_h: float = 0.0,
        params: PlanarScannerProfile | None = None,
    ) -> None:
        """params: which of the profile's scanners; None: the one to localize by."""
        body, params = profile.body, params or profile.planar_scanner
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
        self._poses: deque[tuple[int, Pose2]] = deque()
        self._due_ns: int | None = None

    def step(
        self, now_ns: int, truth: PlantView, moving_now: Callable[[], MovingBodies] | None = None
    ) -> tuple[Array32, Array32] | None:
        """Points (n, 3) base frame at now_ns and intensities (n,) of the turn that ends now, if it is due.

        moving_now  what moves around; it is asked for a turn that is due. None: nothing does
        """
        begin_ns = now_ns - self._turn_ns
        self._poses.append((now_ns, truth.pose_map))
        # One pose before the turn's begin stays, to start from.
        while len(self._poses) > 2 and self._poses[1][0] <= begin_ns:
            self._poses.popleft()
        due_ns = now_ns if self._due_ns is None else self._due_ns
        if len(self._poses) < 2 or now_ns < due_ns:
            return None
        self._due_ns = due_ns + self._every_ns
        way = _Way(self._poses)

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

    def __init__(self, poses: Iterable[tuple[int, Pose2]]) -> None:
        rows = np.array([(stamp_ns, pose.x_m, pose.y_m, pose.yaw_rad) for stamp_ns, pose in poses])
        self._times, self._rows = rows[:, 0], rows[:, 1:]
        self._rows[:, 2] = np.unwrap(self._rows[:, 2])

    def poses(self, times_ns: np.ndarray) -> np.ndarray:
        """(n, 3) x, y, yaw at times (n,), ns."""
        return np.column_stack([np.interp(times_ns, self._times, column) for column in self._rows.T])
