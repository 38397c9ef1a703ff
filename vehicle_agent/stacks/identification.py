"""Control of an identification drive, with the profile's limits."""

from vehicle_agent.config import Profile
from vehicle_agent.control.excitation.excitation_control import ExcitationControl
from vehicle_agent.control.excitation.pedal_program import PedalProgram
from vehicle_agent.signals.rates import TICK_NS
from vehicle_agent.stacks.rooms import brake_map, waypoint_control

# Accelerations and decelerations that the profile's maps would give for the program's steps.
_ACCELS_MPS2 = (0.4, 0.7, 1.0, 0.55, 0.85)
_DECELS_MPS2 = (0.5, 1.4, 0.9, 2.4, 0.7, 1.8, 3.0)
_SPEED_MPS_MAX = 3.0


def pedal_program(profile: Profile) -> PedalProgram:
    """The pedal steps of an identification drive, by the profile's present maps."""
    response, brakes = profile.response, brake_map(profile)
    return PedalProgram(
        throttle_ratios=tuple(
            min(0.7, response.throttle_per_mps2 * (accel + response.coast_mps2)) for accel in _ACCELS_MPS2
        ),
        brake_ratios=tuple(brakes.brake_ratio(decel) for decel in _DECELS_MPS2),
        speed_mps_max=0.9 * min(_SPEED_MPS_MAX, profile.limits.speed_mps_max),
    )


def excitation_control(profile: Profile) -> ExcitationControl:
    """The control room of an identification drive; the same for every stack."""
    return ExcitationControl(waypoint_control(profile), pedal_program(profile), dt_s=TICK_NS * 1e-9)
