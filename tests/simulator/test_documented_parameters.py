"""The modules on the bus behave as their page says."""

from simulator.ecus import by_wire, command_watch, module, report_frames, safety_driver, servo_cart
from tests.documented import differing


def test_the_page_gives_the_parameters_of_the_modules() -> None:
    sources = (by_wire, command_watch, module, report_frames, safety_driver, servo_cart)
    assert differing("simulator/simulator.md", sources) == []
