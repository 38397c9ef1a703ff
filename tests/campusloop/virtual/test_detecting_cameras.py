"""A simulated crossing's camera counts by a people detector that looks at its pictures."""

import numpy as np
import pytest

from campusloop.virtual.detecting_cameras import detector_at
from simulator.sensors.cameras.light import OVERCAST
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import GroundParams
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies
from tests.simulator.sensors.scene.campus import a_street
from vehicle_agent.signals import PEDESTRIAN

pytest.importorskip("cv2", reason="the extra `camera` is not installed")

AREA = a_street().observation_areas[0]
SCENE = StaticScene(a_street(), 1, WorldChanges(parked_ratio=0.0), GroundParams(grade_ratio=0.0))


def people(places: list[tuple[float, float]]) -> Bodies:
    count = len(places)
    poses = np.column_stack((np.array(places).reshape(-1, 2), np.full(count, 1.57)))
    return Bodies(
        np.arange(1, count + 1), np.full(count, PEDESTRIAN), poses, np.tile([0.0, 1.2], (count, 1)),
        np.full((count, 2), 0.5),
    )  # fmt: skip


def test_people_who_walk_over_are_counted_and_those_beside_the_area_are_not() -> None:
    there: list[tuple[float, float]] = []
    detect = detector_at(AREA, SCENE, lambda: people(there), 1, OVERCAST)
    counts = []
    for number in range(9):
        way_m = 0.24 * number
        there[:] = [(68.0, -2.0)] if number < 4 else [(68.0, -2.0), (60.5, way_m - 2.0)]
        counts.append(detect(number * 200_000_000))
    assert counts[:4] == [0] * 4
    assert counts[-2:] == [1, 1]
