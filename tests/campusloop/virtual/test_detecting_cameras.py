"""A simulated crossing's camera counts by a people detector that looks at its pictures."""

import numpy as np
import pytest

from campusloop.virtual.cameras import VirtualCameras
from campusloop.virtual.detecting_cameras import detector_at
from contract.geometry import Array, Pose2
from contract.wire.messages import PresenceReport
from simulator.infrastructure import CameraError, CameraParams
from simulator.riders import NoPhones
from simulator.sensors.cameras.light import OVERCAST
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import GroundParams
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.scene_lidars import SceneOptions
from simulator.traffic.actors import Bodies
from simulator.world import SimWorld, WorldOptions
from tests.simulator.sensors.scene.campus import a_street
from vehicle_agent.config import LidarMount, Profile
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


class _Walkers:
    """People of a world who are where `there` says."""

    def __init__(self) -> None:
        self.there: list[tuple[float, float]] = []

    def bodies(self) -> Bodies:
        return people(self.there)

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """They are moved by the test."""


def a_world(walkers: _Walkers, scene: SceneOptions | None) -> SimWorld:
    profile = Profile(lidar=LidarMount(rate_hz=0.0))
    options = WorldOptions(actors=walkers, scene=scene)
    return SimWorld(a_street(), {"a": profile}, {"a": Pose2(10.0, -1.75, 0.0)}, 1, NoPhones(), options)


def test_a_campus_whose_crossings_have_detectors_reports_what_they_count() -> None:
    walkers, reports = _Walkers(), list[PresenceReport]()
    world = a_world(walkers, SceneOptions(changes=WorldChanges(parked_ratio=0.0)))
    params = CameraParams(latency_s=0.1, dropout=0.0)
    cameras = VirtualCameras(
        a_street(), params, world, lambda _: np.random.default_rng(1), reports.append, detector_seed=1
    )
    for number in range(11):
        walkers.there = [(60.5, 1.2 * (number - 4) - 2.0)] if 4 <= number < 8 else []
        cameras.step(number * 1_000_000_000)
    # A report comes a step after its picture. Who walks on counts at both places for a second.
    counts = [report.count for report in reports]
    assert counts[:4] == [0] * 4
    assert all(1 <= count <= 2 for count in counts[5:8])
    assert counts[-1] == 0, "the person has gone"
    assert reports[-1].age_s >= 0.1


def test_a_detector_without_a_scene_is_refused() -> None:
    world = a_world(_Walkers(), None)
    with pytest.raises(CameraError, match="scene"):
        VirtualCameras(
            a_street(), CameraParams(), world, lambda _: np.random.default_rng(1), print, detector_seed=1
        )
