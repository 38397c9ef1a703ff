"""A vehicle's dynamics drawn from a seed: what a profile of another vehicle does not know.

Nothing of it reaches the vehicle computer, which reads its profile alone.
"""

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from simulator.vehicle.plant import PlantParams, plant_params
from vehicle_agent.config import Profile

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PlantRanges:
    """Ranges of the drawn parameters, each uniform and independent.

    *_share  factor on the nominal value; the others replace it. load_share: of the mass, more or less
    """

    load_share: Range = (-0.2, 0.2)
    wheelbase_share: Range = (0.98, 1.02)
    steer_delay_share: Range = (0.8, 1.2)
    steer_lag_share: Range = (0.8, 1.6)
    steer_bias_rad: Range = (-0.0175, 0.0175)
    steer_play_rad: Range = (0.0, 0.007)
    throttle_delay_share: Range = (0.8, 1.2)
    throttle_lag_share: Range = (0.8, 1.2)
    throttle_full_share: Range = (0.85, 1.15)
    throttle_power: Range = (0.9, 1.15)
    brake_delay_share: Range = (0.8, 1.2)
    brake_lag_share: Range = (0.8, 1.6)
    brake_full_share: Range = (0.85, 1.15)
    brake_knee_share: Range = (0.8, 1.25)
    brake_blend: Range = (0.0, 0.3)
    brake_fade_spm: Range = (0.0, 0.02)
    rolling_drag_share: Range = (0.7, 1.4)
    speed_drag_share: Range = (0.7, 1.4)
    slope_ratio: Range = (0.0, 0.02)
    slope_direction_rad: Range = (-math.pi, math.pi)
    yaw_inertia_share: Range = (0.8, 1.2)
    cog_ratio: Range = (0.44, 0.52)
    cornering_front_share: Range = (0.8, 1.2)
    cornering_rear_share: Range = (0.8, 1.2)
    friction: Range = (0.6, 0.9)


# Parameter of the plant for each range whose name is not the parameter's own.
_SHARES = {
    "wheelbase_share": "wheelbase_m",
    "steer_delay_share": "steer_delay_s",
    "steer_lag_share": "steer_lag_s",
    "throttle_delay_share": "throttle_delay_s",
    "throttle_lag_share": "throttle_lag_s",
    "throttle_full_share": "throttle_full_mps2",
    "brake_delay_share": "brake_delay_s",
    "brake_lag_share": "brake_lag_s",
    "brake_full_share": "brake_full_mps2",
    "brake_knee_share": "brake_knee_mps2",
    "rolling_drag_share": "rolling_drag_mps2",
    "speed_drag_share": "speed_drag_1ps",
    "yaw_inertia_share": "yaw_inertia_kgm2",
    "cornering_front_share": "cornering_front_npr",
    "cornering_rear_share": "cornering_rear_npr",
}


def random_plant(
    profile: Profile, seed: int, vehicle_id: str = "", ranges: PlantRanges = PlantRanges()
) -> PlantParams:
    """The dynamics of one vehicle with tyres, about those of its profile's body.

    seed, vehicle_id  determine every parameter: vehicles of one seed differ, and a new range at the end of
                      PlantRanges changes none of the others
    """
    nominal = nominal_with_tyres(profile)
    rng = np.random.default_rng([seed, *b"plant ", *vehicle_id.encode()])
    changes: dict[str, float] = {}
    for field in fields(ranges):
        value = float(rng.uniform(*getattr(ranges, field.name)))
        if field.name == "load_share":
            changes["load_kg"] = value * nominal.mass_kg
        elif field.name in _SHARES:
            name = _SHARES[field.name]
            changes[name] = value * getattr(nominal, name)
        else:
            changes[field.name] = value
    return replace(nominal, **changes)  # type: ignore[arg-type]


def nominal_with_tyres(profile: Profile) -> PlantParams:
    """The profile's vehicle as a dynamic bicycle."""
    tyres = profile.tyres
    return replace(
        plant_params(profile),
        tyres=True,
        yaw_inertia_kgm2=tyres.yaw_inertia_kgm2,
        cog_ratio=tyres.cog_ratio,
        cornering_front_npr=tyres.cornering_front_npr,
        cornering_rear_npr=tyres.cornering_rear_npr,
    )
