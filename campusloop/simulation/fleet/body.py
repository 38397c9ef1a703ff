"""A light vehicle: a point that follows the mission's line within comfortable limits."""

import bisect
import math
from dataclasses import dataclass

from contract.geometry import Pose2
from contract.roads.routing import ReferenceLine
from vehicle_agent.signals import Ego, Task

SPEED_MPS_MAX = 3.0
ACCEL_MPS2_MAX = 0.8


@dataclass
class Body:
    """pose_map; speed_mps as driven since the last step, so that odometers are right whatever the step."""

    pose_map: Pose2
    speed_mps: float = 0.0
    driven_m: float = 0.0
    _line_id: int = 0
    _s: tuple[float, ...] = ()
    _line: ReferenceLine | None = None
    _s_m: float = 0.0

    def drive(self, task: Task, dt_s: float) -> None:
        """Along the task's line for dt_s, to its stop at most."""
        line = task.line
        if line is None or task.mode in ("idle", "dwell"):
            self.speed_mps = 0.0
            return
        if task.line_id != self._line_id or self._line is not line:
            self._line_id, self._line, self._s_m = task.line_id, line, task.s_m
            self._s = tuple(line.s.tolist())
        left_m = max(0.0, min(task.stop_s_m, self._s[-1]) - self._s_m)
        wanted_mps = min(
            SPEED_MPS_MAX, self.speed_mps + ACCEL_MPS2_MAX * dt_s, math.sqrt(2.0 * ACCEL_MPS2_MAX * left_m)
        )
        step_m = min(left_m, wanted_mps * dt_s)
        self.speed_mps = step_m / dt_s
        if step_m <= 0.0:
            return
        self._s_m += step_m
        self.driven_m += step_m
        self.pose_map = self._pose(line)

    def new_computer(self) -> None:
        """Lines are numbered from the beginning again."""
        self._line_id, self._line, self.speed_mps = 0, None, 0.0

    def ego(self, stamp_ns: int) -> Ego:
        return Ego(stamp_ns, self.pose_map, self.speed_mps, 0.0, 0.0, 0.0, 0.02, stamp_ns, True)

    def _pose(self, line: ReferenceLine) -> Pose2:
        number = min(max(bisect.bisect_right(self._s, self._s_m), 1), len(self._s) - 1)
        (x0, y0), (x1, y1) = line.points[number - 1].tolist(), line.points[number].tolist()
        ratio = (self._s_m - self._s[number - 1]) / (self._s[number] - self._s[number - 1])
        return Pose2(x0 + ratio * (x1 - x0), y0 + ratio * (y1 - y0), math.atan2(y1 - y0, x1 - x0))
