"""The workshop works by the numbers that its pages give."""

from typing import Any

import pytest

from tests.documented import differing
from workshop.calibration.adjustment import Prior
from workshop.calibration.calibrate import CalibrationParams
from workshop.calibration.planes import PlaneSearch
from workshop.cloud_mapping.gnss_fixes import FixParams
from workshop.cloud_mapping.ground import GroundParams
from workshop.cloud_mapping.keyframes import KeyframeParams
from workshop.cloud_mapping.loops import LoopParams as CloudLoopParams
from workshop.cloud_mapping.pose_graph import GraphParams as CloudGraphParams
from workshop.cloud_mapping.submaps import SubmapParams
from workshop.cloud_mapping.surfaces import SurfaceParams
from workshop.detector.training_params import TrainingParams
from workshop.laser_mapping.loops import LoopParams
from workshop.laser_mapping.occupancy import OccupancyParams
from workshop.laser_mapping.pose_graph import GraphParams
from workshop.laser_mapping.refinement import RefinementParams
from workshop.motion_calibration.adjustment import LeverPrior, UnitPrior
from workshop.motion_calibration.calibrate import MotionParams
from workshop.scan_maps.alignment import AlignmentParams
from workshop.scan_maps.comparison import ComparisonParams

PAGES: dict[str, tuple[Any, ...]] = {
    "workshop.md": (LoopParams, RefinementParams, GraphParams, OccupancyParams),
    "workshop/mapping.md": (
        KeyframeParams,
        GroundParams,
        FixParams,
        CloudLoopParams,
        SubmapParams,
        CloudGraphParams,
        SurfaceParams,
    ),
    "vehicle/detector.md": (TrainingParams,),
    "workshop/scan-maps.md": (ComparisonParams, AlignmentParams),
    "workshop/calibration.md": (PlaneSearch, Prior, CalibrationParams),
    "workshop/motion-calibration.md": (MotionParams, UnitPrior, LeverPrior),
}


@pytest.mark.parametrize("page", PAGES)
def test_a_page_gives_the_defaults_of_its_room(page: str) -> None:
    assert differing(page, PAGES[page]) == []
