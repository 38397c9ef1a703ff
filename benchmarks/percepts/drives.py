"""One drive whose percepts are judged: in a module of its own, for other processes to import."""

import argparse

from benchmarks.perception.campus_sweeps import CampusSweeps
from benchmarks.perception.chain_inputs import joined, load_network, yaw_rate_between
from benchmarks.percepts.sightings import Sighting, sightings
from contract.geometry import Pose2
from contract.roads.load import load_map
from simulator.sensors.lidars.mounts import four_lidars
from vehicle_agent.config import load_profile
from vehicle_agent.lidar.models import XT16
from vehicle_agent.stacks.own_perception import point_perception

# Until tracks are confirmed.
_FIRST_TICKS = 6


def sightings_of_drive(arguments: argparse.Namespace, seed: int) -> list[Sighting]:
    """Of all scans, once tracks can be confirmed. arguments: of the command; one drive for each seed."""
    profile = load_profile(arguments.profile)
    body = profile.body
    sweeps = CampusSweeps(
        load_map(arguments.map), body, four_lidars(body, XT16), seed, arguments.speed_mps, arguments.turns
    )
    perception = point_perception(profile)
    grid = perception.grid
    network = load_network(arguments.detector, body)
    state, before = perception.initial(), None
    found: list[Sighting] = []
    for number, sweep in enumerate(sweeps):
        pose: Pose2 = sweep.pose_map
        points, intensities = joined(sweep, arguments.speed_mps, yaw_rate_between(before, pose))
        before = pose
        seen = network(points, intensities, sweep.stamp_ns, pose)
        cells, tracks, state = perception.step(state, points, intensities, sweep.stamp_ns, pose, seen)
        if number >= _FIRST_TICKS:
            # Numbers of other drives are other people.
            found += sightings(number, points, sweep.bodies, pose, cells, tracks, grid)
    return found
