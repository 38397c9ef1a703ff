"""Drives that take up to a fifth longer or shorter than planned. Twenty thousand rides: `make soak`."""

import pytest

from server.domain.rules import FleetRules
from tests.server.dispatch.noise_campaign import run_campaign


@pytest.mark.long
def test_few_promises_break_when_drives_differ_from_the_plan() -> None:
    found = run_campaign(seed=1, rides=400, noise=0.2)
    assert found.rides >= 400
    assert found.broken_ratio <= 0.01


@pytest.mark.long
def test_without_a_reserve_for_the_road_many_more_would() -> None:
    bare = FleetRules(promise_reserve_s=0.0, promise_reserve_ratio=0.0, pickup_slack_ratio=0.0)
    assert run_campaign(seed=1, rides=200, noise=0.2, rules=bare).broken_ratio > 0.02


@pytest.mark.long
def test_no_promise_breaks_when_drives_are_as_planned() -> None:
    assert run_campaign(seed=2, rides=150, noise=0.0).broken == 0
