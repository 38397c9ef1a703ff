"""Is a request one that can be planned for at all?"""

import math

import numpy as np

from vehicle_agent.planning.motion.agents import check_agents
from vehicle_agent.planning.motion.request import MotionRequest, MotionRequestError


def check_request(request: MotionRequest) -> None:
    """Raises MotionRequestError with the defect of the request."""
    corridor = request.corridor
    n = len(corridor.s_m)
    if n == 0:
        raise MotionRequestError("the corridor has no stations")
    for name in ("reference_l_m", "lower_l_m", "upper_l_m", "speed_mps_max"):
        values = getattr(request, name)
        if values.shape != (n,):
            raise MotionRequestError(f"{name} has shape {values.shape}, not {(n,)}")
        if np.isnan(values).any():
            raise MotionRequestError(f"{name} has a NaN")
    if corridor.points_map.shape != (n, 2) or not np.isfinite(corridor.points_map).all():
        raise MotionRequestError("corridor.points_map must be (n, 2) and finite")
    steps = np.diff(corridor.s_m)
    if not np.isfinite(corridor.s_m).all() or (n > 1 and (steps <= 0.0).any()):
        raise MotionRequestError("corridor.s_m must rise")
    if n > 1 and np.ptp(steps) > 0.02 * steps.mean():
        raise MotionRequestError("corridor.s_m must have even steps")
    pose, start = request.start.pose_map, request.start
    known = (pose.x_m, pose.y_m, pose.yaw_rad, start.speed_mps, start.accel_mps2, start.curvature_1pm)
    if not all(math.isfinite(value) for value in known):
        raise MotionRequestError("the start is not finite")
    if request.static_discs.ndim != 2 or request.static_discs.shape[1] != 3:
        raise MotionRequestError(f"static_discs has shape {request.static_discs.shape}, not (m, 3)")
    if not np.isfinite(request.static_discs).all():
        raise MotionRequestError("static_discs are not finite")
    if math.isnan(request.end_s_m):
        raise MotionRequestError("end_s_m is NaN")
    check_agents(request.agents)
