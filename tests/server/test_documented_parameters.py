"""The fleet runs by the numbers that its pages give."""

import math
from dataclasses import fields
from typing import Any

import pytest

from server.dispatch.engine.search.optimise import Settings
from server.dispatch.engine.search.partition import Partitioning
from server.domain.rules import FleetRules
from server.fleet import backlog, event_intake, hub, link, presence, sent_messages
from server.fleet.hub import Hub
from server.loops.solver import ProcessSolver
from server.store import engine, transactions
from server.store.writing import retries, writer
from server.usecases.orders import orders, sections, visits
from server.usecases.roads import road_positions
from tests.documented import DOCS, differing, documented_defaults

PAGES = [f"server/{path.name}" for path in sorted((DOCS / "server").glob("*.md"))]
DOCUMENTED = documented_defaults(PAGES)
RULES = [field.name for field in fields(FleetRules) if isinstance(field.default, int | float)]


@pytest.mark.parametrize(
    "name", [name for name in RULES if not isinstance(getattr(FleetRules(), name), bool)]
)
def test_a_rule_of_the_fleet_is_documented_with_its_default(name: str) -> None:
    default = float(getattr(FleetRules(), name))
    assert name in DOCUMENTED, f"no table of docs/server gives {name}"
    assert all(math.isclose(value, default) for value in DOCUMENTED[name]), (DOCUMENTED[name], default)


@pytest.mark.parametrize(
    ("page", "sources"),
    [
        ("dispatch-engine", (Settings, Partitioning)),
        ("fleet", (Hub, hub, link, backlog, sent_messages, presence, event_intake)),
        ("loops", (ProcessSolver,)),
        ("store", (engine, transactions, writer, retries)),
        ("usecases", (visits, sections, orders, road_positions)),
    ],
)
def test_a_page_gives_the_defaults_of_its_room(page: str, sources: tuple[Any, ...]) -> None:
    assert differing(f"server/{page}.md", sources) == []
