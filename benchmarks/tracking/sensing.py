"""How a vehicle that is measured knows where it is: by GNSS and inertial sensor, or exactly."""

from collections.abc import Callable

import numpy as np

from contract.roads.model import Origin
from simulator.sensors.gnss import GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu, ImuNoise
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Profile
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.signals import Ego, VehicleMotion
from vehicle_agent.stacks.rooms import rear_slip_per_mps2

ORIGIN = Origin(30.6187, -96.3365)

Sensing = Callable[[int, PlantView, VehicleMotion], Ego]


def noisy(seed: int, noise: GnssNoise, profile: Profile) -> Sensing:
    """Receiver, inertial sensor and the localization of a vehicle's stack."""
    rng = np.random.default_rng([seed, 2])
    receiver, imu = GnssReceiver(ORIGIN, noise, rng), Imu(ImuNoise(), rng)
    localization = GnssInsLocalization(ORIGIN, slip_s2pm=rear_slip_per_mps2(profile))
    state = localization.initial()

    def sense(now_ns: int, truth: PlantView, motion: VehicleMotion) -> Ego:
        nonlocal state
        fix = receiver.fix(now_ns, truth)
        assert fix is not None
        ego, state = localization.step(state, motion, (fix, imu.sample(now_ns, truth)), now_ns)
        return ego

    return sense


def perfect(now_ns: int, truth: PlantView, motion: VehicleMotion) -> Ego:
    """Localization without errors."""
    return Ego(
        now_ns, truth.pose_map, truth.speed_mps, truth.accel_mps2, truth.yaw_rate_radps, motion.steer_rad,
        0.0, now_ns, True,
    )  # fmt: skip
