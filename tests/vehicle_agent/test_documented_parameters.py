"""A room drives by the numbers that its page gives."""

import inspect
import math
from typing import Any

import pytest

from tests.documented import documented_defaults
from vehicle_agent.can import handshake, module_state
from vehicle_agent.gate.settings import GateSettings
from vehicle_agent.guard.collision import Avoidance
from vehicle_agent.guard.guard import Guard
from vehicle_agent.guard.limits import Limits
from vehicle_agent.link import client, clock, outbox, session
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.seat_button import StopRules
from vehicle_agent.perception.cells import HeightMapPerception
from vehicle_agent.perception.tracker import AlphaBetaTracker
from vehicle_agent.signals import rates
from vehicle_agent.world.area_monitor import AreaMonitor
from vehicle_agent.world.observed import ObservedWorld
from vehicle_agent.world.prediction import Predictor
from vehicle_agent.world.surroundings import Surroundings
from vehicle_agent.world.view import VisibilityParams

PAGES: dict[str, tuple[Any, ...]] = {
    "onboard": (rates,),
    "guard": (Guard, Avoidance, Limits),
    "gate": (GateSettings,),
    "can": (handshake, module_state),
    "mission": (MissionRules, StopRules),
    "link": (session, clock, client, outbox),
    "world": (Surroundings, Predictor, VisibilityParams, AreaMonitor, ObservedWorld),
    "perception": (HeightMapPerception, AlphaBetaTracker),
}


def defaults(source: Any) -> dict[str, float]:
    """The numbers that a module has, or a class is given by default, by name."""
    if isinstance(source, type):
        found = {name: given.default for name, given in inspect.signature(source).parameters.items()}
    else:
        found = vars(source)
    return {
        name: float(value)
        for name, value in found.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }


@pytest.mark.parametrize("page", PAGES)
def test_a_page_gives_the_defaults_of_its_room(page: str) -> None:
    documented = documented_defaults([f"vehicle/{page}.md"])
    for source in PAGES[page]:
        shared = defaults(source).keys() & documented.keys()
        assert shared, f"docs/vehicle/{page}.md documents nothing of {source.__name__}"
        for name in shared:
            default = defaults(source)[name]
            assert any(math.isclose(value, default) for value in documented[name]), (
                name,
                documented[name],
                default,
            )
