"""The workshop works by the numbers that its page gives."""

from tests.documented import differing
from workshop.laser_mapping.loops import LoopParams
from workshop.laser_mapping.occupancy import OccupancyParams
from workshop.laser_mapping.pose_graph import GraphParams
from workshop.laser_mapping.refinement import RefinementParams


def test_the_page_gives_the_defaults_of_the_workshop() -> None:
    sources = (LoopParams, RefinementParams, GraphParams, OccupancyParams)
    assert differing("workshop.md", sources) == []
