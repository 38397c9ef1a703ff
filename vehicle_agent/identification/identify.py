"""From a recorded drive to the vehicle's profile, with the uncertainty of each value."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from vehicle_agent.config import Profile
from vehicle_agent.identification.drive_signals import (
    DriveSignals,
    IdentificationError,
    check_drive,
)
from vehicle_agent.identification.pedal_fit import (
    BRAKE_DEAD,
    BRAKE_FADE,
    BRAKE_GAIN,
    BRAKE_LAG,
    BRAKE_LOG_KNEE,
    BRAKE_OFFSET,
    DRAG,
    ROLLING,
    THROTTLE_DEAD,
    THROTTLE_FADE,
    THROTTLE_LAG,
    THROTTLE_PER,
    PedalFit,
    fit_pedals,
)
from vehicle_agent.identification.steering_fit import (
    BIAS,
    PLAY,
    STEER_DEAD,
    STEER_LAG,
    UNDERSTEER,
    WHEELBASE,
    SteeringFit,
    fit_steering,
)

# A value beyond these is no vehicle that the controllers were proven with.
_DEAD_S_MAX = 0.6
_BIAS_RAD_MAX = 0.05
_PLAY_RAD_MAX = 0.03
_WHEELBASE_SHARE_MAX = 0.15
_FULL_BRAKE_MPS2_MIN = 2.5
# A worse fit means that something else moved the vehicle: a hill, wheels that spun, a driver.
_RESIDUAL_RMS_MAX = 4.0
_DEAD_STD_S_MAX = 0.03
# What the fits cannot see, as standard deviations beside those of the fits: reports are stamped in ticks, and
# the models leave out a throttle's exact curve and the tyres' transients.
_DEAD_MODEL_S, _WHEELBASE_MODEL_M, _BIAS_MODEL_RAD = 0.005, 0.004, 0.0001
_WHEELBASE_STD_M_MAX = 0.05


@dataclass(frozen=True, slots=True)
class IdentifiedValue:
    """std: standard deviation, with what the model leaves out; NaN for a value that is computed of others."""

    name: str
    value: float
    std: float
    unit: str


@dataclass(frozen=True, slots=True)
class Identification:
    """profile: the given one with what was identified; values: to print; the fits: to plot."""

    profile: Profile
    values: tuple[IdentifiedValue, ...]
    pedals: PedalFit
    steering: SteeringFit


def identify(drive: DriveSignals, profile: Profile) -> Identification:
    """The vehicle's response by a drive. profile: the vehicle's present one.

    Raises IdentificationError for a drive that does not show it, and for a vehicle outside the range in which
    the controllers are proven.
    """
    check_drive(drive)
    steering = fit_steering(drive, profile.response, profile.body)
    pedals = fit_pedals(drive, profile.response, float(steering.turning.values[WHEELBASE]))
    identified = _profile(profile, pedals, steering)
    _check_range(identified, profile, pedals, steering)
    return Identification(identified, _values(identified, pedals, steering), pedals, steering)


def _profile(profile: Profile, pedals: PedalFit, steering: SteeringFit) -> Profile:
    p, turning = pedals.fit.values, steering.turning.values
    dead_s, lag_s = steering.response.values[[STEER_DEAD, STEER_LAG]].tolist()
    gain = float(p[BRAKE_GAIN])
    # The map holds at the mean speed of the brakings.
    left = max(0.1, 1.0 - float(p[BRAKE_FADE]) * pedals.mean_mps)
    response = msgspec.structs.replace(
        profile.response,
        brake_gain=_rounded(gain),
        brake_offset=_rounded(float(p[BRAKE_OFFSET]) - gain * math.log(left)),
        brake_knee_mps2=_rounded(left * math.exp(float(p[BRAKE_LOG_KNEE]))),
        coast_mps2=_rounded(max(0.0, float(p[ROLLING] + p[DRAG] * pedals.mean_mps))),
        throttle_per_mps2=_rounded(float(p[THROTTLE_PER])),
        throttle_fade_mps=_rounded(1.0 / max(float(p[THROTTLE_FADE]), 0.02)),
        steer_delay_s=_rounded(dead_s + lag_s),
        brake_delay_s=_rounded(float(p[BRAKE_DEAD] + p[BRAKE_LAG])),
        steer_dead_s=_rounded(dead_s),
        steer_lag_s=_rounded(lag_s),
        throttle_dead_s=_rounded(float(p[THROTTLE_DEAD])),
        throttle_lag_s=_rounded(float(p[THROTTLE_LAG])),
        brake_dead_s=_rounded(float(p[BRAKE_DEAD])),
        brake_lag_s=_rounded(float(p[BRAKE_LAG])),
        steer_bias_rad=_rounded(float(turning[BIAS])),
    )
    body = msgspec.structs.replace(profile.body, wheelbase_m=_rounded(float(turning[WHEELBASE])))
    # Gate and guard rely on the full brake: never on more than was measured.
    limits = msgspec.structs.replace(
        profile.limits,
        decel_mps2_max=_rounded(min(profile.limits.decel_mps2_max, _full_brake_mps2(response))),
    )
    driving = msgspec.structs.replace(profile.driving, identification_drive=False)
    return msgspec.structs.replace(profile, body=body, limits=limits, response=response, driving=driving)


def _full_brake_mps2(response: object) -> float:
    """Deceleration of the full pedal, extrapolated by the map."""
    gain, offset, knee = (getattr(response, f"brake_{name}") for name in ("gain", "offset", "knee_mps2"))
    return float(math.exp(min((1.0 - offset) / gain, 5.0)) - knee)


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")


def _check_range(identified: Profile, before: Profile, pedals: PedalFit, steering: SteeringFit) -> None:
    response = identified.response
    deads = {
        "steering": response.steer_dead_s,
        "throttle": response.throttle_dead_s,
        "brake": response.brake_dead_s,
    }
    for name, dead_s in deads.items():
        if dead_s > _DEAD_S_MAX:
            raise _outside(f"the {name} answers after {dead_s:.2f} s, more than {_DEAD_S_MAX} s")
    if abs(response.steer_bias_rad) > _BIAS_RAD_MAX:
        raise _outside(
            f"the wheels stand {math.degrees(response.steer_bias_rad):.1f} degrees off; align them"
        )
    play_rad = float(steering.turning.values[PLAY])
    if play_rad > _PLAY_RAD_MAX:
        raise _outside(f"the steering has {math.degrees(play_rad):.1f} degrees of play; repair it")
    share = identified.body.wheelbase_m / before.body.wheelbase_m - 1.0
    if abs(share) > _WHEELBASE_SHARE_MAX:
        raise _outside(
            f"the vehicle turns as if its wheelbase were {identified.body.wheelbase_m:.2f} m; check the "
            "profile's body and steering column"
        )
    full_mps2 = _full_brake_mps2(response)
    if full_mps2 < _FULL_BRAKE_MPS2_MIN:
        raise _outside(f"the full brake gives {full_mps2:.1f} m/s2, less than {_FULL_BRAKE_MPS2_MIN}")
    _check_fit(pedals, steering)


def _check_fit(pedals: PedalFit, steering: SteeringFit) -> None:
    for name, residuals in (("speeds", pedals.fit.residuals), ("yaw rates", steering.turning.residuals)):
        rms = float(np.sqrt(np.mean(residuals**2)))
        if rms > _RESIDUAL_RMS_MAX:
            raise _outside(f"the {name} do not follow the model ({rms:.1f} times their noise)")
    deads = (
        ("throttle", pedals.fit.std[THROTTLE_DEAD]),
        ("brake", pedals.fit.std[BRAKE_DEAD]),
        ("steering", steering.response.std[STEER_DEAD]),
    )
    for name, std_s in deads:
        if std_s > _DEAD_STD_S_MAX:
            raise IdentificationError(
                "too_short",
                f"the dead time of the {name} is uncertain by {std_s:.2f} s; drive more steps of it",
            )
    std_m = float(steering.turning.std[WHEELBASE])
    if std_m > _WHEELBASE_STD_M_MAX:
        raise IdentificationError(
            "never_turned", f"the wheelbase is uncertain by {std_m:.2f} m; drive narrower curves"
        )


def _outside(detail: str) -> IdentificationError:
    return IdentificationError("outside_range", detail)


def _with(model_std: float, fit_std: float) -> float:
    return math.hypot(model_std, float(fit_std))


def _values(profile: Profile, pedals: PedalFit, steering: SteeringFit) -> tuple[IdentifiedValue, ...]:
    response, none = profile.response, math.nan
    pedal_std, turn, turn_std = pedals.fit.std, steering.turning.values, steering.turning.std
    return (
        IdentifiedValue("brake_gain", response.brake_gain, float(pedal_std[BRAKE_GAIN]), ""),
        IdentifiedValue("brake_offset", response.brake_offset, float(pedal_std[BRAKE_OFFSET]), ""),
        IdentifiedValue("brake_knee_mps2", response.brake_knee_mps2, none, "m/s2"),
        IdentifiedValue(
            "brake_dead_s", response.brake_dead_s, _with(_DEAD_MODEL_S, pedal_std[BRAKE_DEAD]), "s"
        ),
        IdentifiedValue("brake_lag_s", response.brake_lag_s, float(pedal_std[BRAKE_LAG]), "s"),
        IdentifiedValue("full brake", _full_brake_mps2(response), none, "m/s2"),
        IdentifiedValue("coast_mps2", response.coast_mps2, float(pedal_std[ROLLING]), "m/s2"),
        IdentifiedValue(
            "throttle_per_mps2", response.throttle_per_mps2, float(pedal_std[THROTTLE_PER]), "1/(m/s2)"
        ),
        IdentifiedValue("throttle_fade_mps", response.throttle_fade_mps, none, "m/s"),
        IdentifiedValue(
            "throttle_dead_s", response.throttle_dead_s, _with(_DEAD_MODEL_S, pedal_std[THROTTLE_DEAD]), "s"
        ),
        IdentifiedValue("throttle_lag_s", response.throttle_lag_s, float(pedal_std[THROTTLE_LAG]), "s"),
        IdentifiedValue(
            "steer_dead_s",
            response.steer_dead_s,
            _with(_DEAD_MODEL_S, steering.response.std[STEER_DEAD]),
            "s",
        ),
        IdentifiedValue("steer_lag_s", response.steer_lag_s, float(steering.response.std[STEER_LAG]), "s"),
        IdentifiedValue(
            "steer_bias_rad", response.steer_bias_rad, _with(_BIAS_MODEL_RAD, turn_std[BIAS]), "rad"
        ),
        IdentifiedValue(
            "wheelbase_m", profile.body.wheelbase_m, _with(_WHEELBASE_MODEL_M, turn_std[WHEELBASE]), "m"
        ),
        IdentifiedValue("steering play", float(turn[PLAY]), float(turn_std[PLAY]), "rad"),
        IdentifiedValue("understeer", float(turn[UNDERSTEER]), float(turn_std[UNDERSTEER]), "s2/m m"),
    )
