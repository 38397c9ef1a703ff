"""The page of cameras gives the parameters of the people counter."""

from campusloop.crossing_cameras.people_counter import CounterParams
from tests.documented import differing


def test_the_page_gives_the_parameters_of_the_counter() -> None:
    assert differing("simulator/cameras.md", (CounterParams,)) == []
