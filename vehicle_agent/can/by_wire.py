"""The codec and the gate's interface for a profile's `[by_wire] kind`."""

from vehicle_agent.can.braking import ByWireBraking
from vehicle_agent.can.motion_reports import DecodedReports, MotionReports
from vehicle_agent.can.pacmod.braking import PacmodBraking
from vehicle_agent.can.pacmod.codec import Pacmod, pacmod
from vehicle_agent.can.servo.braking import ServoBraking
from vehicle_agent.can.servo.codec import ServoCart, servo_cart
from vehicle_agent.config import Profile


def codec_of(profile: Profile) -> Pacmod | ServoCart:
    """The can room for the vehicle's by-wire."""
    return servo_cart(profile) if profile.by_wire.kind == "servo" else pacmod(profile)


def motion_reports_of(profile: Profile) -> MotionReports:
    """The decoder of module reports for the gate."""
    if profile.by_wire.kind == "servo":
        return DecodedReports(servo_cart(profile))
    return DecodedReports(pacmod(profile))


def braking_of(profile: Profile) -> ByWireBraking:
    """The gate's interface to the vehicle's by-wire."""
    if profile.by_wire.kind == "servo":
        return ServoBraking(profile.steering, profile.by_wire)
    return PacmodBraking(profile.steering)
