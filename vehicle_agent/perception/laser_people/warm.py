"""Compiles the kernel of the room into numba's cache."""

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.perception.laser_people.people import LaserPeople, LaserPeopleState


def warm_laser_people() -> None:
    """Two scans of one thing: cluster, track."""
    room, state = LaserPeople(), LaserPeopleState()
    angles = np.linspace(-0.02, 0.02, 9)
    for number in (1, 2):
        state = room.after_scan(
            state, np.full(9, 8.0), angles, np.eye(4), Pose2(0.0, 0.0, 0.0), number * 40_000_000
        )
    assert len(state.tracks) == 1
