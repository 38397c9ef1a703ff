"""The workshop works by the numbers that its pages give."""

from typing import Any

import pytest

from tests.documented import differing
from workshop.calibration.adjustment import Prior
from workshop.calibration.calibrate import CalibrationParams
from workshop.calibration.planes import PlaneSearch
from workshop.laser_mapping.loops import LoopParams
from workshop.laser_mapping.occupancy import OccupancyParams
from workshop.laser_mapping.pose_graph import GraphParams
from workshop.laser_mapping.refinement import RefinementParams

PAGES: dict[str, tuple[Any, ...]] = {
    "workshop.md": (LoopParams, RefinementParams, GraphParams, OccupancyParams),
    "workshop/calibration.md": (PlaneSearch, Prior, CalibrationParams),
}


@pytest.mark.parametrize("page", PAGES)
def test_a_page_gives_the_defaults_of_its_room(page: str) -> None:
    assert differing(page, PAGES[page]) == []
