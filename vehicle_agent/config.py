"""The vehicle profile (TOML): frozen structs of parameters.

A profile is read once. Every room gets its own part.
"""

import math
from pathlib import Path as FilePath
from typing import Annotated, Literal

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1000.0)]


class ProfileError(Exception):
    """The vehicle profile cannot be used; the message names the field or line."""


class Body(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The vehicle's outline and steering geometry, base frame (rear-axle centre)."""

    length_m: float = 4.35
    width_m: float = 1.63
    height_m: float = 2.28
    wheelbase_m: float = 2.6
    rear_overhang_m: float = 0.85
    turn_radius_m_min: float = 5.0
    mass_kg: float = 1400.0
    seats: int = 6
    wheelchair_places: int = 0

    @property
    def front_overhang_m(self) -> float:
        """From the rear axle to the front bumper."""
        return self.length_m - self.rear_overhang_m


class Limits(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Limits of autonomous driving.

    accel_mps2_top  of accelerations planned at speed_mps_max, where a motor gives less; from accel_mps2_max
                    at rest it falls linearly with the speed. None: the same at every speed
    """

    speed_mps_max: float = 3.0
    accel_mps2_max: float = 0.8
    accel_mps2_top: float | None = None
    decel_mps2_comfort: float = 0.8
    decel_mps2_max: float = 5.6
    steer_rate_radps_max: float = 0.6
    lateral_accel_mps2_max: float = 0.5

    def __post_init__(self) -> None:
        """ValueError for a drive that does not accelerate, or more at speed than at rest."""
        if not self.accel_mps2_max > 0.0:
            raise ValueError("accel_mps2_max must be above 0")
        if self.accel_mps2_top is not None and not 0.0 < self.accel_mps2_top <= self.accel_mps2_max:
            raise ValueError("accel_mps2_top must be above 0 and at most accel_mps2_max")


class LidarMount(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Position of a lidar, base frame; a VLP-16 scans 16 rings from -15 to +15 degrees.

    rate_hz 0: the vehicle has no lidar. retro_intensity_min: returns of retro-reflectors are brighter; a
    VLP-16's calibrated reflectivity has them above 100 of 255
    """

    x_m: float = 3.2
    y_m: float = 0.0
    z_m: float = 2.28
    rings: int = 16
    columns: int = 1800
    rate_hz: float = 10.0
    range_m_max: float = 100.0
    elevation_rad_min: float = -0.2617993877991494
    elevation_rad_max: float = 0.2617993877991494
    retro_intensity_min: float = 100.5


class PlanarScanner(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A laser scanner of one level layer, base frame, and its field of view about yaw_rad.

    rate_hz      scans that are used each second; 0: the vehicle has none. mirror_hz: turns of its mirror
    field_rad    of view; step_rad: between two beams
    range_m_max  farther returns are not used
    """

    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 1.9
    yaw_rad: float = 0.0
    field_rad: float = 1.5 * math.pi
    step_rad: float = math.radians(0.5)
    rate_hz: float = 0.0
    mirror_hz: float = 50.0
    range_m_max: float = 50.0

    def __post_init__(self) -> None:
        """ValueError for a scanner that no vehicle has."""
        if not 0.0 <= self.rate_hz <= self.mirror_hz <= 50.0:
            raise ValueError("rate_hz must be 0 to mirror_hz, and mirror_hz at most 50")
        if not 0.0 < self.step_rad < self.field_rad <= 2.0 * math.pi:
            raise ValueError("field_rad must be above step_rad and at most a full turn")


class Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A camera ahead that tells people from other things, base frame; pictures without distortion.

    down_rad   its axis below the horizon; field_rad: horizontal field of view
    rate_hz    pictures that are looked at each second; 0: the vehicle has none
    """

    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 1.7
    yaw_rad: float = 0.0
    down_rad: float = 0.0
    field_rad: float = math.radians(50.0)
    width_px: int = 640
    height_px: int = 480
    rate_hz: float = 0.0

    def __post_init__(self) -> None:
        """ValueError for a camera that no vehicle has."""
        if not 0.0 <= self.rate_hz <= 50.0:
            raise ValueError("rate_hz must be 0 to 50")
        if not (0.05 <= self.field_rad <= 2.6 and self.width_px >= 16 and self.height_px >= 16):
            raise ValueError("a camera has at least 16 x 16 px and a field_rad of 0.05 to 2.6")


class Tyres(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Tyres and inertia of the vehicle.

    cog_ratio  centre of gravity behind the front axle over the wheelbase; cornering_*_npr: stiffness of an
    axle
    """

    yaw_inertia_kgm2: float = 1800.0
    cog_ratio: float = 0.48
    cornering_front_npr: float = 60_000.0
    cornering_rear_npr: float = 70_000.0


class SteeringColumn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Steering-wheel angle from front-wheel angle d, in degrees: linear * d - quadratic * d * |d|.

    Defaults: a real GEM e2.
    """

    linear: float = 21.775
    quadratic: float = 0.1084


class ByWire(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The vehicle's drive-by-wire, and parameters of a servo conversion.

    kind                   "pacmod": a PACMod3-class module; "servo": motors on steering and brake, a PWM
                           voltage for the throttle (docs/vehicle/can.md)
    throttle_duty_min, _max  PWM duty at which the motor begins to turn, and at full throttle
    brake_travel_free      travel of the brake servo before the pads touch
    track_width_m          between the front wheels: the encoder sits on the left one
    wheel_radius_m         rolling radius; a PACMod's wheel speeds are compared with its vehicle speed by it
    """

    kind: Literal["pacmod", "servo"] = "pacmod"
    throttle_duty_min: float = 0.15
    throttle_duty_max: float = 0.90
    brake_travel_free: float = 0.10
    track_width_m: float = 0.98
    wheel_radius_m: Positive = 0.28


class Response(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The vehicle's response to its actuators, identified on the vehicle (docs/vehicle/control.md).

    brake_*        pedal = gain ln(a + knee) + offset for a deceleration a (m/s2); GEM: 0.28, 0.90, 0
    coast_mps2     deceleration with neither pedal
    throttle_per_mps2  pedal per acceleration
    accel_filter_s low-pass on the measured acceleration; GEM: 2 s
    *_delay_s      from a command to its effect
    *_dead_s, *_lag_s  the same split into dead time and first-order lag
    throttle_fade_mps  speed at which full throttle no longer accelerates
    steer_bias_rad     true front-wheel angle minus the reported one
    """

    brake_gain: float = 0.2473
    brake_offset: float = 0.5695
    brake_knee_mps2: float = 0.1
    coast_mps2: float = 0.15
    throttle_per_mps2: float = 0.42
    accel_filter_s: float = 2.0
    steer_delay_s: float = 0.28
    brake_delay_s: float = 0.25
    steer_dead_s: float = 0.25
    steer_lag_s: float = 0.05
    throttle_dead_s: float = 0.25
    throttle_lag_s: float = 0.15
    brake_dead_s: float = 0.2
    brake_lag_s: float = 0.05
    throttle_fade_mps: float = 8.0
    steer_bias_rad: float = 0.0

    def __post_init__(self) -> None:
        """ValueError for a response that no vehicle has, which a typing error or a failed fit gives."""
        for name in ("brake_gain", "throttle_per_mps2", "throttle_fade_mps"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be above 0")
        for name in ("brake_knee_mps2", "coast_mps2"):
            if not 0.0 <= getattr(self, name) <= 5.0:
                raise ValueError(f"{name} must be 0 to 5 m/s2")
        for name in self.__struct_fields__:
            if name.endswith(("_dead_s", "_delay_s", "_lag_s")) and not 0.0 <= getattr(self, name) <= 1.5:
                raise ValueError(f"{name} must be 0 to 1.5 s; the controllers predict no farther")
        if not -0.1 <= self.steer_bias_rad <= 0.1:
            raise ValueError("steer_bias_rad must be -0.1 to 0.1; align the wheels")


class Driving(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Driving style. obstacles: "line" sweeps the route to 5 (v + 1) m, "paper" the steering arc to 15 m.

    waypoint_files  folder and prefix of recorded waypoint files, one a speed, for the GEM stack: it drives
                    the one of the highest speed of `limits`; empty: the map's lines

    jerk_mps3_max  of the acceleration that is planned, and commanded by a controller that plans it; full
                   stops excepted
    identification_drive  control drives the pedals by a program (docs/vehicle/identification.md); on a closed
                   site only
    """

    heading_gain_1ps: float = 2.4
    heading_integral_1ps2: float = 0.0
    obstacles: Literal["line", "paper"] = "line"
    clearance_m: float = 0.4
    stop_decel_mps2: float = 0.6
    waypoint_files: str = ""
    jerk_mps3_max: float = 1.7
    identification_drive: bool = False


class Announcing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the vehicle says to people; another place may want a quieter or a more patient vehicle.

    stopping_m     a stop is announced this far before it
    ahead_m        inattentive people farther ahead of the bumper are not addressed
    step_aside_s   a person for whom the vehicle has stood this long is asked to step aside
    aside_again_s  shortest time between two such sentences
    courtesy_s     shortest time between two courtesies (after you, passing)
    """

    stopping_m: Positive = 20.0
    ahead_m: Positive = 10.0
    step_aside_s: Positive = 10.0
    aside_again_s: Positive = 10.0
    courtesy_s: Positive = 30.0


class Signalling(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Turn signals, headlights and horn, of a by-wire that has them.

    kerb          the side of the pavement, on which the vehicle stops
    turn_ahead_m  a turn is signalled this far before it begins
    stop_ahead_m  a stop at the kerb is signalled this far before it
    headlights    low beam "always", or at "dusk": from sunset on, and while nobody has said what time it is.
                  "off": never. High beam would dazzle people on foot and is never commanded
    horn          "imminent_contact": half a second when the guard brakes fully before somebody; or "never"
    """

    kerb: Literal["right", "left"] = "right"
    turn_ahead_m: Positive = 25.0
    stop_ahead_m: Positive = 15.0
    headlights: Literal["always", "dusk", "off"] = "dusk"
    horn: Literal["imminent_contact", "never"] = "imminent_contact"


class Profile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Everything about one kind of vehicle; `stack` names the implementation that fills the rooms.

    perception  who finds road users: "own" the agent in its lidars' scans, "tracker" another computer on the
                vehicle, which sends tracks. Simulated trackers are made of the truth
    planar_scanner, people_scanner  over people's heads, to localize by; at the height of a hip, to see people
    camera      looks at what people_scanner finds
    """

    name: str = "campus-shuttle"
    stack: Literal["gem", "nus", "snow_lion"] = "gem"
    fail_action: Literal["coast", "spring_brake"] = "coast"
    perception: Literal["own", "tracker"] = "tracker"
    body: Body = Body()
    tyres: Tyres = Tyres()
    limits: Limits = Limits()
    lidar: LidarMount = LidarMount()
    planar_scanner: PlanarScanner = PlanarScanner()
    people_scanner: PlanarScanner = PlanarScanner()
    camera: Camera = Camera()
    steering: SteeringColumn = SteeringColumn()
    by_wire: ByWire = ByWire()
    response: Response = Response()
    driving: Driving = Driving()
    announcing: Announcing = Announcing()
    signalling: Signalling = Signalling()

    @property
    def has_tracker(self) -> bool:
        """Tracks come from another computer of the vehicle."""
        return self.perception == "tracker"


def load_profile(path: FilePath) -> Profile:
    """Raises ProfileError with the field at fault."""
    try:
        return msgspec.toml.decode(path.read_bytes(), type=Profile)
    except FileNotFoundError as error:
        raise ProfileError(f"no vehicle profile at {path}; see vehicle_agent/profiles/") from error
    except msgspec.DecodeError as error:
        raise ProfileError(f"{path}: {error}") from error


def profile_toml(profile: Profile) -> str:
    """The profile in the format that `load_profile` reads."""
    sections = msgspec.to_builtins(profile)
    lines = [f"{key} = {_toml(value)}" for key, value in sections.items() if not isinstance(value, dict)]
    for name, values in sections.items():
        if isinstance(values, dict):
            lines += ["", f"[{name}]"]
            # TOML has no null: what has no value is left out, as in a file written by hand.
            lines += [f"{key} = {_toml(value)}" for key, value in values.items() if value is not None]
    return "\n".join(lines) + "\n"


def _toml(value: str | float | bool) -> str:
    return msgspec.json.encode(value).decode()
