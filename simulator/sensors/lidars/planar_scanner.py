"""A laser scanner of one layer, such as the NUS paper's vehicles have."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.sensors.lidars.firings import Array32, Times
from simulator.sensors.lidars.response import LidarResponse, response_row
from simulator.sensors.lidars.scanner import MovingBodies, Scanner, Trajectory, Turn
from simulator.sensors.scene.changes import SceneError
from simulator.sensors.scene.static_scene import CastScene, StaticScene

# SICK's data sheet: 18 m at 10 %, 12 mm (1 sigma), spots that widen by 15 mrad.
LMS151_RESPONSE = LidarResponse(range_std_m=0.012, range_10_m=18.0, divergence_rad=0.015)


@dataclass(frozen=True, slots=True, eq=False)
class PlanarMount:
    """One scanner and its place; the defaults are those of a SICK LMS151.

    T_base_sensor  (4, 4); x ahead in the middle of the field of view, y left
    field_rad      of view; beams are `step_rad` apart, the first at the right
    rate_hz        turns of the mirror a second
    """

    name: str
    T_base_sensor: Array
    field_rad: float = 1.5 * math.pi
    step_rad: float = math.radians(0.5)
    rate_hz: float = 50.0
    range_m: tuple[float, float] = (0.5, 50.0)
    response: LidarResponse = LMS151_RESPONSE

    def __post_init__(self) -> None:
        """Raises SceneError for a field of view that no mirror has."""
        if not (0.0 < self.step_rad < self.field_rad <= 2.0 * math.pi and self.rate_hz > 0.0):
            raise SceneError(f"field_rad must be 0 to 2 pi and step_rad less, not {self}")


@dataclass(frozen=True, slots=True, eq=False)
class PlanarScan:
    """One turn: what `vehicle_agent.localization.laser` takes, and the beams' times.

    ranges_m     (n,) inf where nothing returns
    angles_rad   (n,) from the sensor's x axis, left positive, rising
    offsets_ns   (n,) after stamp_ns
    """

    stamp_ns: int
    ranges_m: Array
    angles_rad: Array
    intensities: Array32
    offsets_ns: Times


class PlanarScanner:
    """One scanner of one vehicle; each beam is cast from the pose that the vehicle has when it fires."""

    def __init__(
        self,
        mounted: PlanarMount,
        scene: StaticScene,
        rng: np.random.Generator,
        own_body: CastScene | None = None,
        rain_mm_per_h: float = 0.0,
    ) -> None:
        self.mounted = mounted
        self.period_ns = round(1e9 / mounted.rate_hz)
        beams = 1 + math.floor(mounted.field_rad / mounted.step_rad + 1e-9)
        if mounted.field_rad >= 2.0 * math.pi - 1e-9:
            beams -= 1
        self._angles_rad: Array = mounted.step_rad * (np.arange(beams, dtype=np.float64) - 0.5 * (beams - 1))
        level = np.column_stack((np.cos(self._angles_rad), np.sin(self._angles_rad), np.zeros(beams)))
        offsets_ns = np.rint(mounted.step_rad / (2.0 * math.pi) * self.period_ns * np.arange(beams))
        turn = Turn(level.astype(np.float32), offsets_ns.astype(np.int64), np.zeros(beams, np.uint16), 1)
        params = response_row(mounted.response, mounted.range_m, rain_mm_per_h, scene.changes.sway_m)
        self._scanner = Scanner(turn, mounted.T_base_sensor, params, scene, rng, own_body)

    def scan(self, trajectory: Trajectory, begin_ns: int, moving: Sequence[MovingBodies] = ()) -> PlanarScan:
        """The turn that begins at begin_ns; trajectory and moving as in `SpinningLidar.scan`."""
        returns = self._scanner.measure(trajectory, begin_ns, moving, self.mounted.range_m[1])
        ranges: Array = np.where(returns.ranges > 0.0, returns.ranges, np.inf).astype(np.float64)
        return PlanarScan(
            begin_ns, ranges, self._angles_rad, returns.intensities, self._scanner.turn.offsets_ns
        )
