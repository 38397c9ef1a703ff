"""People and vehicles for the tests of the model."""

import numpy as np

from contract.geometry import Array
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.people import AwarePeople
from simulator.traffic.aware.ways import own_ways
from simulator.traffic.recordings import RecordedTrack
from vehicle_agent.signals import PEDESTRIAN

PARAMS = ReactionParams()
DT_S = 0.02


def a_walk(
    number: int, start: tuple[float, float], velocity_mps: tuple[float, float], lasts_s: float = 20.0
) -> RecordedTrack:
    """A person who walks straight on from time 0."""
    times = np.arange(0.0, lasts_s + 1e-9, 0.1)
    places = np.array(start) + times[:, None] * np.array(velocity_mps)
    yaw = np.full(len(times), np.arctan2(velocity_mps[1], velocity_mps[0]))
    states = np.column_stack((places, yaw, np.tile(velocity_mps, (len(times), 1))))
    return RecordedTrack(number, PEDESTRIAN, times, states, (0.5, 0.5))


def a_crowd(*people: RecordedTrack, from_s: float = 0.0, limits: Array | None = None) -> AwarePeople:
    """The people on their ways, with everyone's fitted limits unless given."""
    ways = own_ways([(person.times_s, person.states) for person in people])
    if limits is None:
        limits = PARAMS.limits(len(people))
    ends_s = max((float(person.times_s[-1]) for person in people), default=0.0)
    return AwarePeople([p.number for p in people], ways, limits, PARAMS, from_s, ends_s)


def a_vehicle(x_m: float, y_m: float, speed_mps: float, yaw_rad: float = 0.0) -> Array:
    """(1, 7) the shuttle's row, its rear axle at x, y."""
    return np.array([[x_m, y_m, yaw_rad, 0.85, 3.5, 0.815, speed_mps]])


def drive(
    crowd: AwarePeople, vehicle: Array, seconds: float, accel_mps2: float = 0.0
) -> list[tuple[float, Array]]:
    """Move the vehicle straight on; (time, places (n, 2)) after each step. The row is changed in place."""
    out = []
    for _ in range(round(seconds / DT_S)):
        vehicle[0, 6] = max(0.0, vehicle[0, 6] + accel_mps2 * DT_S)
        vehicle[0, 0] += np.cos(vehicle[0, 2]) * vehicle[0, 6] * DT_S
        vehicle[0, 1] += np.sin(vehicle[0, 2]) * vehicle[0, 6] * DT_S
        crowd.step(vehicle, DT_S)
        out.append((crowd.clock_s, crowd.places.copy()))
    return out
