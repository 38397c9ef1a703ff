"""Steering-wheel angle <-> front-wheel angle of the bicycle model, by the profile's column."""

import math

from vehicle_agent.config import Body, Limits, SteeringColumn


def wheel_from_front(column: SteeringColumn, steer_rad: float) -> float:
    """The steering-wheel angle (rad) that gives this front-wheel angle; left positive both.

    GEM, section III: linear * d - quadratic * d * |d|, with d in degrees.
    """
    d = math.degrees(steer_rad)
    return math.radians(column.linear * d - column.quadratic * d * abs(d))


def front_from_wheel(column: SteeringColumn, wheel_rad: float) -> float:
    """The inverse of `wheel_from_front` on its rising branch; a larger wheel angle gives the peak."""
    w = math.degrees(abs(wheel_rad))
    if column.quadratic == 0.0:
        d = w / column.linear
    else:
        root = max(column.linear * column.linear - 4.0 * column.quadratic * w, 0.0)
        d = 2.0 * w / (column.linear + math.sqrt(root))
    return math.copysign(math.radians(d), wheel_rad)


def wheel_rate_radps(column: SteeringColumn, body: Body, limits: Limits) -> float:
    """Rate of the steering wheel or shaft at the front wheels' rate limit, mean from straight to lock."""
    lock_rad = math.atan(body.wheelbase_m / body.turn_radius_m_min)
    return limits.steer_rate_radps_max * wheel_from_front(column, lock_rad) / lock_rad
