"""Side slip of a dynamic bicycle with linear tyres, limited by friction.

Rajamani, Vehicle Dynamics and Control, chapter 2.3, with the lateral speed at the rear-axle centre. Slip
angles are not meaningful below walking speed, so there the motion is blended into the kinematic bicycle.
"""

import math

from numba import njit

GRAVITY_MPS2 = 9.81
# Fully kinematic below the first, fully dynamic above the second.
BLEND_MPS = (1.0, 2.0)


@njit(cache=True)
def slipped(
    speed: float, side: float, yaw_rate: float, steer: float, along_mps2: float,
    wheelbase: float, cog_ratio: float, mass: float, inertia: float,
    stiff_front: float, stiff_rear: float, friction: float, dt: float,
) -> tuple[float, float, float]:  # fmt: skip
    """(side speed, yaw rate, acceleration along x) after dt.

    speed, side   of the rear-axle centre, along and across the vehicle, m/s; left positive
    steer         of the front wheels, rad
    along_mps2    longitudinal acceleration of the tyres, shared by the axles as their loads; it reduces the
                  lateral friction
    cog_ratio     centre of gravity behind the front axle over the wheelbase
    stiff_*       cornering stiffness of each axle, N/rad; mass in kg, inertia in kg m2
    """
    front = cog_ratio * wheelbase
    rear = wheelbase - front
    rolling = speed * math.tan(steer) / wheelbase
    if speed < BLEND_MPS[0]:
        return 0.0, rolling, 0.0
    slip_front = math.atan2(side + wheelbase * yaw_rate, speed) - steer
    slip_rear = math.atan2(side, speed)
    grip = math.sqrt(max(0.0, (friction * GRAVITY_MPS2) ** 2 - along_mps2 * along_mps2)) * mass / wheelbase
    force_front = min(max(-stiff_front * slip_front, -grip * rear), grip * rear)
    force_rear = min(max(-stiff_rear * slip_rear, -grip * front), grip * front)
    across = force_front * math.cos(steer)
    turning = (front * across - rear * force_rear) / inertia
    sideways = (across + force_rear) / mass - speed * yaw_rate
    centre_side = side + rear * yaw_rate + sideways * dt
    turned = yaw_rate + turning * dt
    moved = centre_side - rear * turned
    drag = -force_front * math.sin(steer) / mass + (side + rear * yaw_rate) * yaw_rate
    share = min(1.0, (speed - BLEND_MPS[0]) / (BLEND_MPS[1] - BLEND_MPS[0]))
    share = share * share * (3.0 - 2.0 * share)
    return share * moved, share * turned + (1.0 - share) * rolling, share * drag
