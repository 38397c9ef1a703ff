"""The vehicles' true motion: a bicycle model with actuators that have dead time, lag and limits.

Kinematic unless a vehicle's `tyres` are switched on (`simulator/vehicle/tyres.py`). All vehicles are stepped
together. Frames as onboard: the pose is the rear-axle centre in the map frame.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from contract.geometry import Array, Pose2, wrap_angle
from simulator.vehicle.tyres import slipped
from vehicle_agent.config import Profile

SUBSTEP_S = 0.005
# columns of the state
X, Y, YAW, SPEED, ACCEL, STEER, THROTTLE, BRAKE, ODOMETER, ENERGY, SIDE_SPEED, YAW_RATE, PLAYED = range(13)
STATE_SIZE = 13
GRAVITY_MPS2 = 9.81
# Beyond it wheels spin or lock, which no shuttle's pedals do on dry ground.
_SLIP_MAX = 0.2
# columns of a command: front-wheel angle and its rate limit, pedals, direction (1, -1, 0 for none), lock
CMD_STEER, CMD_RATE, CMD_THROTTLE, CMD_BRAKE, CMD_DIRECTION, CMD_LOCK = range(6)
COMMAND_SIZE = 6


@dataclass(frozen=True, slots=True)
class PlantParams:
    """One vehicle's dynamics. SI units; delays are pure dead time, lags first-order time constants.

    steer_bias_rad  the true front-wheel angle minus the reported one
    load_kg         beyond mass_kg, for which the pedals' accelerations hold; negative for a lighter vehicle
    grade_ratio     slope of the road along the vehicle, uphill positive
    slope_ratio     slope of the whole site, which rises towards slope_direction_rad of the map
    steer_play_rad  the wheels move only after the steering has turned by this much the other way
    brake_blend     share of the brake's force that follows full b^power instead of the knee curve
    brake_fade_spm  share of its force that the brake loses per m/s of speed
    throttle_power  acceleration = full throttle^power
    wheel_slip_s2pm  the driven wheels turn faster than they roll by this share per m/s2 of their force
    wheel_radius_ratio  true radius of the tyres over the one that the reports are made with
    tyres           side slip of a dynamic bicycle; without it the wheels roll where they point
    cog_ratio       centre of gravity behind the front axle, as a share of the wheelbase
    cornering_*     stiffness of an axle, both wheels; friction limits its force

    The brake follows decel = knee ((full / knee + 1)^b - 1), the inverse of the GEM paper's logarithmic
    brake map b = k ln(a) + c. Dead time and lag together make the paper's 0.27 s: 3 m/s stops in 1.6 m.
    """

    wheelbase_m: float = 2.6
    steer_rad_max: float = 0.4795
    steer_rate_radps_max: float = 0.8
    steer_delay_s: float = 0.25
    steer_lag_s: float = 0.05
    throttle_delay_s: float = 0.25
    throttle_lag_s: float = 0.15
    throttle_full_mps2: float = 2.5
    brake_delay_s: float = 0.2
    brake_lag_s: float = 0.05
    brake_full_mps2: float = 5.6
    brake_knee_mps2: float = 0.1
    rolling_drag_mps2: float = 0.12
    speed_drag_1ps: float = 0.02
    speed_mps_max: float = 8.0
    mass_kg: float = 1400.0
    battery_j: float = 8.6e3 * 3600.0
    idle_power_w: float = 900.0
    drive_efficiency: float = 0.75
    steer_bias_rad: float = 0.0
    load_kg: float = 0.0
    grade_ratio: float = 0.0
    tyres: bool = False
    yaw_inertia_kgm2: float = 1800.0
    cog_ratio: float = 0.48
    cornering_front_npr: float = 60_000.0
    cornering_rear_npr: float = 70_000.0
    friction: float = 0.8
    slope_ratio: float = 0.0
    slope_direction_rad: float = 0.0
    steer_play_rad: float = 0.0
    brake_blend: float = 0.0
    brake_power: float = 2.5
    brake_fade_spm: float = 0.0
    throttle_power: float = 1.0
    wheel_slip_s2pm: float = 0.0
    wheel_radius_ratio: float = 1.0

    def row(self) -> Array:
        """The parameters as the kernel takes them, in the order of the fields."""
        return np.array([getattr(self, name) for name in self.__slots__], dtype=np.float64)


(
    P_WHEELBASE, P_STEER_MAX, P_STEER_RATE, P_STEER_DELAY, P_STEER_LAG,
    P_THROTTLE_DELAY, P_THROTTLE_LAG, P_THROTTLE_FULL,
    P_BRAKE_DELAY, P_BRAKE_LAG, P_BRAKE_FULL, P_BRAKE_KNEE,
    P_ROLLING, P_SPEED_DRAG, P_SPEED_MAX, P_MASS, P_BATTERY, P_IDLE, P_EFFICIENCY,
    P_STEER_BIAS, P_LOAD, P_GRADE, P_TYRES, P_INERTIA, P_COG, P_STIFF_FRONT, P_STIFF_REAR, P_FRICTION,
    P_SLOPE, P_SLOPE_DIRECTION, P_PLAY, P_BRAKE_BLEND, P_BRAKE_POWER, P_BRAKE_FADE, P_THROTTLE_POWER,
    P_WHEEL_SLIP, P_WHEEL_RADIUS,
) = range(37)  # fmt: skip
PARAMS_SIZE = 37


def plant_params(profile: Profile) -> PlantParams:
    """The dynamics of a vehicle with this profile's geometry; the other parameters have defaults."""
    body = profile.body
    return PlantParams(
        wheelbase_m=body.wheelbase_m,
        steer_rad_max=math.atan(body.wheelbase_m / body.turn_radius_m_min) * 1.02,
        brake_full_mps2=profile.limits.decel_mps2_max,
        mass_kg=body.mass_kg,
    )


@dataclass(frozen=True, slots=True)
class PlantView:
    """One vehicle's true motion.

    grade_ratio       slope under it along its heading, uphill positive
    wheel_ratio       speed that the wheels report over the true one: they slip, and tyres wear
    """

    pose_map: Pose2
    speed_mps: float
    accel_mps2: float
    steer_rad: float
    throttle_ratio: float
    brake_ratio: float
    yaw_rate_radps: float
    odometer_m: float
    battery_ratio: float
    grade_ratio: float = 0.0
    wheel_ratio: float = 1.0


class Plant:
    """All vehicles of a world, in one array. `commands` is (n, COMMAND_SIZE), held until changed.

    charging_w  (n,) power into each battery from outside, held until changed
    grades      (n,) slope of the road under each vehicle along its heading, on top of that of its parameters;
                held until changed
    """

    def __init__(self, params: tuple[PlantParams, ...], poses_map: tuple[Pose2, ...]) -> None:
        n = len(params)
        self._params = params
        self._rows = np.array([p.row() for p in params]).reshape(n, PARAMS_SIZE)
        longest_s = max(max(p.steer_delay_s, p.throttle_delay_s, p.brake_delay_s) for p in params)
        slots = round(longest_s / SUBSTEP_S) + 1
        self.state: Array = np.zeros((n, STATE_SIZE))
        for i, (p, pose) in enumerate(zip(params, poses_map, strict=True)):
            self.state[i, :3] = pose.x_m, pose.y_m, pose.yaw_rad
            self.state[i, ENERGY] = p.battery_j
        self.charging_w: Array = np.zeros(n)
        self.grades: Array = np.zeros(n)
        self._own_grades: Array = self._rows[:, P_GRADE].copy()
        self.commands: Array = np.zeros((n, COMMAND_SIZE))
        self.commands[:, CMD_RATE] = self._rows[:, P_STEER_RATE]
        self._history: Array = np.zeros((n, slots, COMMAND_SIZE))
        self._head = 0

    def step(self, duration_s: float) -> None:
        """Advance by a multiple of SUBSTEP_S under the present commands."""
        substeps = round(duration_s / SUBSTEP_S)
        self._rows[:, P_GRADE] = self._own_grades + self.grades
        self._head = advance_plant(
            self.state, self.commands, self._history, self._head, self._rows, SUBSTEP_S, substeps
        )
        charged = self.state[:, ENERGY] + self.charging_w * duration_s
        self.state[:, ENERGY] = np.minimum(charged, self._rows[:, P_BATTERY])

    def view(self, i: int) -> PlantView:
        x, y, yaw, v, a, steer, throttle, brake, odometer, energy, _, yaw_rate, played = self.state[
            i
        ].tolist()
        p = self._params[i]
        if not p.tyres:
            yaw_rate = v * math.tan(played + p.steer_bias_rad) / p.wheelbase_m
        grade = p.grade_ratio + float(self.grades[i])
        if p.slope_ratio:
            grade += p.slope_ratio * math.cos(yaw - p.slope_direction_rad)
        return PlantView(
            Pose2(x, y, yaw), v, a, steer, throttle, brake,
            yaw_rate, odometer, energy / p.battery_j, grade, _wheel_ratio(v, a, grade, p),
        )  # fmt: skip

    def place(self, i: int, pose_map: Pose2, speed_mps: float = 0.0) -> None:
        """Place a vehicle, at rest or with a speed."""
        self.state[i, :3] = pose_map.x_m, pose_map.y_m, pose_map.yaw_rad
        self.state[i, [SPEED, ACCEL, SIDE_SPEED, YAW_RATE]] = 0.0
        self.state[i, SPEED] = speed_mps


def _wheel_ratio(speed_mps: float, accel_mps2: float, grade: float, p: PlantParams) -> float:
    """Reported over true speed of wheels that slip under their force, which also carries the vehicle uphill.

    Rajamani, Vehicle Dynamics and Control, chapter 4.2: for small slip the force is proportional to it.
    """
    if not p.wheel_slip_s2pm:
        return 1.0 / p.wheel_radius_ratio
    force_mps2 = math.copysign(1.0, speed_mps) * (accel_mps2 + GRAVITY_MPS2 * grade)
    slip = min(max(p.wheel_slip_s2pm * force_mps2, -_SLIP_MAX), _SLIP_MAX)
    return (1.0 + slip) / p.wheel_radius_ratio


@njit(cache=True)
def brake_decel(brake: float, full_mps2: float, knee_mps2: float) -> float:
    """Deceleration (m/s2) of a pedal at `brake` (0..1): 0 at 0, full at 1, rising."""
    decel: float = knee_mps2 * ((full_mps2 / knee_mps2 + 1.0) ** brake - 1.0)
    return decel


@njit(cache=True)
def brake_force_mps2(brake: float, speed: float, p: Array) -> float:
    """Deceleration by the brake alone, for a vehicle of its nominal mass."""
    decel = brake_decel(brake, p[P_BRAKE_FULL], p[P_BRAKE_KNEE])
    if p[P_BRAKE_BLEND] > 0.0:
        powered = p[P_BRAKE_FULL] * max(brake, 0.0) ** p[P_BRAKE_POWER]
        decel += p[P_BRAKE_BLEND] * (powered - decel)
    faded: float = decel * max(0.0, 1.0 - p[P_BRAKE_FADE] * abs(speed))
    return faded


@njit(cache=True)
def throttle_force_mps2(throttle: float, speed: float, p: Array) -> float:
    """Acceleration by the motor alone, for a vehicle of its nominal mass."""
    fade = max(0.0, 1.0 - abs(speed) / p[P_SPEED_MAX])
    opened = throttle
    if p[P_THROTTLE_POWER] != 1.0:
        opened = max(throttle, 0.0) ** p[P_THROTTLE_POWER]
    force: float = p[P_THROTTLE_FULL] * opened * fade
    return force


@njit(cache=True)
def _delayed(history: Array, head: int, column: int, delay_s: float, dt_s: float, vehicle: int) -> float:
    slots = history.shape[1]
    back = round(delay_s / dt_s)
    return float(history[vehicle, (head - back) % slots, column])


@njit(cache=True)
def _lag(value: float, target: float, lag_s: float, dt_s: float) -> float:
    if lag_s <= 0.0:
        return target
    return value + (target - value) * (1.0 - math.exp(-dt_s / lag_s))


@njit(cache=True)
def _turn_wheels(steer: float, target: float, rate: float, p: Array, dt: float) -> float:
    target = min(max(target, -p[P_STEER_MAX]), p[P_STEER_MAX])
    move = _lag(steer, target, p[P_STEER_LAG], dt) - steer
    reach = min(rate, p[P_STEER_RATE]) * dt
    turned: float = steer + min(max(move, -reach), reach)
    return turned


@njit(cache=True)
def _next_speed(v: float, drive: float, hold: float, p: Array, dt: float) -> float:
    """Speed after dt: `drive` is signed by direction, `hold` opposes motion and holds at rest."""
    if v == 0.0 and abs(drive) <= hold:
        return 0.0
    way = 1.0 if v > 0.0 or (v == 0.0 and drive > 0.0) else -1.0
    v_next: float = v + (drive - way * hold) * dt
    if v_next * way < 0.0:
        v_next = 0.0
    v_next = min(max(v_next, -p[P_SPEED_MAX]), p[P_SPEED_MAX])
    return v_next


@njit(cache=True)
def advance_plant(
    state: Array, commands: Array, history: Array, head: int, rows: Array, dt: float, substeps: int
) -> int:
    """Advance every vehicle in place by `substeps` of dt; returns the new head of the command history.

    state (n, STATE_SIZE), commands (n, COMMAND_SIZE), history (n, slots, COMMAND_SIZE) ring,
    rows (n, PARAMS_SIZE).
    """
    n, slots = state.shape[0], history.shape[1]
    for _ in range(substeps):
        head = (head + 1) % slots
        for i in range(n):
            p = rows[i]
            s = state[i]
            history[i, head, :] = commands[i, :]
            target = _delayed(history, head, CMD_STEER, p[P_STEER_DELAY], dt, i)
            s[STEER] = _turn_wheels(s[STEER], target, commands[i, CMD_RATE], p, dt)
            throttle = _delayed(history, head, CMD_THROTTLE, p[P_THROTTLE_DELAY], dt, i)
            brake = _delayed(history, head, CMD_BRAKE, p[P_BRAKE_DELAY], dt, i)
            s[THROTTLE] = _lag(s[THROTTLE], throttle, p[P_THROTTLE_LAG], dt)
            s[BRAKE] = _lag(s[BRAKE], brake, p[P_BRAKE_LAG], dt)
            v = s[SPEED]
            # The pedals' forces are the same whatever the vehicle weighs.
            lightness = p[P_MASS] / (p[P_MASS] + p[P_LOAD])
            motor = lightness * commands[i, CMD_DIRECTION] * throttle_force_mps2(s[THROTTLE], v, p)
            hold = (
                p[P_ROLLING]
                + p[P_SPEED_DRAG] * abs(v)
                + lightness * brake_force_mps2(s[BRAKE], v, p)
                + commands[i, CMD_LOCK] * p[P_BRAKE_FULL]
            )
            half_play = 0.5 * p[P_PLAY]
            s[PLAYED] = min(max(s[PLAYED], s[STEER] - half_play), s[STEER] + half_play)
            wheels = s[PLAYED] + p[P_STEER_BIAS]
            grade = p[P_GRADE] + p[P_SLOPE] * math.cos(s[YAW] - p[P_SLOPE_DIRECTION])
            drive, side, yaw_rate = motor - GRAVITY_MPS2 * grade, 0.0, 0.0
            if p[P_TYRES] > 0.0:
                side, yaw_rate, drag = slipped(
                    v, s[SIDE_SPEED], s[YAW_RATE], wheels, motor - hold,
                    p[P_WHEELBASE], p[P_COG], p[P_MASS] + p[P_LOAD], p[P_INERTIA],
                    p[P_STIFF_FRONT], p[P_STIFF_REAR], p[P_FRICTION], dt,
                )  # fmt: skip
                drive += drag
            v_next = _next_speed(v, drive, hold, p, dt)
            s[ACCEL] = (v_next - v) / dt
            mean = 0.5 * (v + v_next)
            if p[P_TYRES] <= 0.0:
                yaw_rate = mean * math.tan(wheels) / p[P_WHEELBASE]
            s[SIDE_SPEED], s[YAW_RATE] = side, yaw_rate
            heading = s[YAW] + 0.5 * yaw_rate * dt
            s[X] += (mean * math.cos(heading) - side * math.sin(heading)) * dt
            s[Y] += (mean * math.sin(heading) + side * math.cos(heading)) * dt
            s[YAW] = wrap_angle(s[YAW] + yaw_rate * dt)
            s[SPEED] = v_next
            s[ODOMETER] += abs(mean) * dt
            power = p[P_IDLE] + max(0.0, motor * mean) * (p[P_MASS] + p[P_LOAD]) / p[P_EFFICIENCY]
            s[ENERGY] = max(0.0, s[ENERGY] - power * dt)
    return head
