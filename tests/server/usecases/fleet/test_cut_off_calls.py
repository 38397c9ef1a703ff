"""Calls that no road leads to any more, on a line of places a minute apart."""

from dataclasses import replace

import numpy as np
import pytest

from server.dispatch.problem import Call, Problem, VehicleState
from server.domain.planning.plans import PlannedVisit
from server.usecases.fleet.cut_off_calls import cut_off_calls, way_out_s, without_riders

PLACES = 5
TIMES = 60.0 * np.abs(np.arange(PLACES)[:, None] - np.arange(PLACES)[None, :])


def shuttle(*places: int, locked: int = 0, cut_off: int = -1) -> tuple[Problem, VehicleState]:
    """It is at place 0."""
    times = TIMES.copy()
    if cut_off >= 0:
        times[:, cut_off] = np.inf
    calls = tuple(Call(place, call_id=f"call-{number}") for number, place in enumerate(places))
    vehicle = VehicleState("shuttle-1", times[0], 0.0, 6, 1, (), calls, locked)
    return Problem((vehicle,), {}, times), vehicle


def lost(problem: Problem, vehicle: VehicleState) -> list[str]:
    return [call.call_id for call in cut_off_calls(problem, vehicle)]


def test_every_call_that_no_road_leads_to_is_cut_off_and_those_behind_it_are_not() -> None:
    assert lost(*shuttle(1, 2, 3)) == []
    assert lost(*shuttle(1, 2, 3, 2, 4, cut_off=2)) == ["call-1", "call-3"]


def test_the_way_goes_on_from_the_last_call_that_is_reached() -> None:
    problem, vehicle = shuttle(1, 2, 3)
    problem.times[1, 3] = np.inf
    assert lost(problem, vehicle) == []
    problem.times[2, 3] = np.inf
    assert lost(problem, vehicle) == ["call-2"]
    problem.times[1, 2] = np.inf
    problem.times[1, 3] = 120.0
    assert lost(problem, vehicle) == ["call-1"]


def test_the_stop_where_a_shuttle_stands_is_not_cut_off() -> None:
    assert lost(*shuttle(2, 3, cut_off=2, locked=1)) == []
    assert lost(*shuttle(2, 3, 2, cut_off=2, locked=1)) == ["call-2"]


def test_time_off_between_shifts_needs_no_road() -> None:
    problem, vehicle = shuttle(2, 3, 2, cut_off=2)
    off = replace(vehicle.calls[0], off_duty=True)
    assert lost(problem, replace(vehicle, calls=(off, *vehicle.calls[1:]))) == ["call-2"]


@pytest.mark.parametrize(("locked", "place"), [(0, 0), (1, 2), (2, 4)])
def test_riders_get_out_behind_the_calls_that_stay(locked: int, place: int) -> None:
    problem, vehicle = shuttle(2, 4, 3, locked=locked)
    np.testing.assert_array_equal(way_out_s(problem, vehicle), TIMES[place], strict=True)


def visit(name: str, board: str = "", alight: str = "", **more: object) -> PlannedVisit:
    return PlannedVisit(name, "stop", name, "lane", 0.0, tuple(board.split()), tuple(alight.split()), **more)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "kept",
    [
        visit("who else boards", board="ann bob"),
        visit("who else alights", alight="bob ann"),
        visit("one boards and another alights", board="ann", alight="bob"),
        visit("a call of a departure", board="ann", departure_id="first@2026-11-23"),
        visit("where it stands", alight="ann", state="under_way"),
        visit("a rest"),
    ],
    ids=lambda kept: kept.visit_id,
)
def test_a_visit_stays_for_whatever_else_it_is_made(kept: PlannedVisit) -> None:
    (left,) = without_riders([kept], {"ann"})
    assert "ann" not in (*left.board, *left.alight)
    others = {"board": tuple({*kept.board} - {"ann"}), "alight": tuple({*kept.alight} - {"ann"})}
    assert left == replace(kept, **others)  # type: ignore[arg-type]


def test_a_visit_that_was_made_for_the_riders_alone_goes() -> None:
    visits = [visit("1", board="ann cid"), visit("2", board="bob"), visit("3", alight="ann")]
    assert without_riders(visits, {"ann", "cid"}) == [visits[1]]
