"""Whoever is in the way with the back turned is asked to step aside; nobody else is."""

import math

import pytest

from tests.vehicle_agent.hmi.streets import PATH, TASK, TICK_NS, path, verdict, world
from vehicle_agent.config import Profile
from vehicle_agent.hmi import texts
from vehicle_agent.stacks.rooms import announcer

Person = tuple[float, float, float, float, float]
NORTH, WEST = 0.5 * math.pi, math.pi


def heard(person: Person, seconds: float, missing: frozenset[int] = frozenset()) -> list[tuple[float, str]]:
    """(t, text) of everything spoken; the person keeps the place before a vehicle that goes with it."""
    room = announcer(Profile())
    state, spoken = room.initial(), []
    for k in range(1, round(seconds * 50)):
        now_ns = k * TICK_NS
        scan = k // 5
        people = [] if scan in missing else [person]
        around = world(scan * 5 * TICK_NS, people)
        says, state = room.step(state, TASK, PATH, around, verdict(), now_ns)
        if says.announce == texts.SAY_STEP_ASIDE[0]:
            spoken.append((k * 0.02, says.screen))
    return spoken


# The bumper is at x = 13.5.
@pytest.mark.parametrize(
    "person",
    [
        pytest.param((18.0, 0.3, 0.0, 0.0, 0.0), id="stands with the back turned"),
        pytest.param((18.0, 0.3, 0.4, 1.0, 0.2), id="walks away in the way"),
        pytest.param((20.0, -0.9, -0.3, 0.0, 0.0), id="at the edge of the way"),
    ],
)
def test_an_inattentive_person_in_the_way_is_asked_once(person: Person) -> None:
    spoken = heard(person, 30.0)
    assert len(spoken) == 1
    at_s, screen = spoken[0]
    assert 3.0 <= at_s <= 6.5
    assert screen == texts.STEP_ASIDE[0]


@pytest.mark.parametrize(
    "person",
    [
        pytest.param((18.0, 0.3, WEST, 0.0, 0.0), id="looks at the vehicle"),
        pytest.param((18.0, 0.3, 0.0, -1.0, 0.0), id="walks towards it"),
        pytest.param((18.0, 0.3, NORTH, 0.0, 1.2), id="crosses"),
        pytest.param((18.0, 2.5, 0.0, 0.0, 0.0), id="beside the way"),
        pytest.param((30.0, 0.0, 0.0, 0.0, 0.0), id="far ahead"),
        pytest.param((5.0, 0.0, 0.0, 0.0, 0.0), id="behind"),
    ],
)
def test_others_are_left_in_peace(person: Person) -> None:
    assert heard(person, 15.0) == []


def test_a_tracker_that_misses_a_scan_does_not_start_the_wait_afresh() -> None:
    missing = frozenset(range(4, 200, 7))
    assert len(heard((18.0, 0.0, 0.0, 0.0, 0.0), 20.0, missing)) == 1


def test_somebody_seen_only_now_and_then_is_not_taken_for_standing() -> None:
    missing = frozenset(k for k in range(600) if k % 20 > 3)
    assert heard((18.0, 0.0, 0.0, 0.0, 0.0), 20.0, missing) == []


def test_the_sentence_is_kept_for_who_the_planner_waits_for_when_farther_beside() -> None:
    room, person = announcer(Profile()), (18.0, 1.3, 0.0, 0.0, 0.0)
    for named, asked in (((), 0), ((1,), 1)):
        state, count = room.initial(), 0
        for k in range(1, 500):
            says, state = room.step(
                state,
                TASK,
                path(yields_to=named),
                world(k // 5 * 5 * TICK_NS, [person]),
                verdict(),
                k * TICK_NS,
            )
            count += says.announce == texts.SAY_STEP_ASIDE[0]
        assert count == asked


def test_a_held_vehicle_asks_nobody() -> None:
    room = announcer(Profile())
    state = room.initial()
    for k in range(1, 600):
        around = world(k // 5 * 5 * TICK_NS, [(18.0, 0.0, 0.0, 0.0, 0.0)])
        says, state = room.step(state, TASK, PATH, around, verdict("held"), k * TICK_NS)
        assert says.announce != texts.SAY_STEP_ASIDE[0]
        assert says.screen != texts.STEP_ASIDE[0]
