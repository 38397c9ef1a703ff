"""What a camera over an intersection is worth past hidden corners; its lies and silence harm nobody."""

from functools import cache
from pathlib import Path

import msgspec
import pytest

from campusloop.scenes.drive import SceneRun
from campusloop.scenes.scenario_files.scenario import drive
from campusloop.scenes.scenario_files.scenario_file import ScenarioFile
from campusloop.scenes.stacks import profile_of

CORNER = """
title = "Between two huts into an intersection"
max_time_s = 90.0
[road]
path = [[0, 0], [70, 0]]
width_m = 4.0
[[road.area]]
id = "junction"
s_m = 26.0
length_m = 20.0
reach_m = 6.0
kind = "intersection"
[[occluder]]
at = [33, 2.6]
length_m = 6.0
width_m = 1.6
[[occluder]]
at = [33, -2.6]
length_m = 6.0
width_m = 1.6
"""
CAMERA = '[[camera]]\narea = "junction"\nsays = "{says}"\n'
LOST = "lost_s = 3.0\n"
# Comes out from behind a hut when the shuttle is so near, and sees nothing.
WALKER = """
[[person]]
at = [36.6, 3.0]
heading_deg = -90
way = [[36.6, -5]]
speed_mps = 1.4
when = {{ distance_m = {distance_m} }}
"""


@cache
def driven(text: str) -> SceneRun:
    return drive(
        msgspec.toml.decode(text, type=ScenarioFile), "corner", profile_of("snow_lion"), Path(), None
    ).run


def time_s(run: SceneRun) -> float:
    assert run.time_s is not None
    assert not run.metrics.front_contacts
    return run.time_s


@pytest.mark.long
def test_a_camera_that_sees_nobody_saves_time_past_hidden_corners_and_a_lost_one_saves_none() -> None:
    without = time_s(driven(CORNER))
    told = time_s(driven(CORNER + CAMERA.format(says="truth")))
    lost = time_s(driven(CORNER + CAMERA.format(says="truth") + LOST))
    assert told < without - 0.05
    assert told < lost - 0.05


@pytest.mark.parametrize(
    "distance_m", [5.8, *(pytest.param(m, marks=pytest.mark.long) for m in (5.2, 5.5, 6.0, 6.2))]
)
def test_a_camera_that_lies_leads_the_vehicle_into_nobody(distance_m: float) -> None:
    """Whenever they come out: how old the camera's picture is then must not matter. They may walk into a
    vehicle that stands already."""
    walker = WALKER.format(distance_m=distance_m)
    run = driven(CORNER + walker + CAMERA.format(says="always_clear"))
    time_s(run)
    assert [contact for contact in run.metrics.other_contacts if contact[2] > 0.1] == []
