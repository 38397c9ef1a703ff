"""A plan follows the vehicle's word, and only forwards."""

import pytest

from contract.wire.messages import VisitKind, VisitState
from server.domain.errors import IllegalTransition
from server.domain.planning.plans import (
    VISIT_TRANSITIONS,
    Plan,
    PlannedVisit,
    with_visit_state,
)

STATES: tuple[VisitState, ...] = ("pending", "under_way", "done", "skipped")


def a_plan() -> Plan:
    visits = tuple(
        PlannedVisit(f"visit-{k}", "stop", f"stop-{k}", "lane", float(k), board=(f"ride-{k}",))
        for k in range(3)
    )
    return Plan("campus", "shuttle-1", 4, visits, "rest-1")


@pytest.mark.parametrize("before", STATES)
@pytest.mark.parametrize("after", STATES)
def test_a_visit_never_goes_backwards(before: VisitState, after: VisitState) -> None:
    visit = PlannedVisit("visit-0", "stop", "a", "lane", 0.0, state=before)
    plan = Plan("campus", "shuttle-1", 1, (visit,))
    if before == after:
        assert with_visit_state(plan, "visit-0", after) is plan
    elif after in VISIT_TRANSITIONS[before]:
        assert with_visit_state(plan, "visit-0", after).version == 2
    else:
        with pytest.raises(IllegalTransition):
            with_visit_state(plan, "visit-0", after)


def test_a_visit_that_is_done_leaves_the_plan() -> None:
    after = with_visit_state(a_plan(), "visit-0", "done")
    assert [visit.visit_id for visit in after.visits] == ["visit-1", "visit-2"]
    assert after.version == 5
    assert after.resting_place_id == "rest-1"


def test_arriving_at_a_later_visit_leaves_the_earlier_ones_behind() -> None:
    after = with_visit_state(a_plan(), "visit-1", "under_way")
    assert [visit.visit_id for visit in after.visits] == ["visit-1", "visit-2"]
    assert after.under_way is not None


def test_word_of_a_visit_that_the_plan_no_longer_has_is_no_news() -> None:
    plan = a_plan()
    assert with_visit_state(plan, "elsewhere", "done") is plan


def test_the_rides_of_a_plan_are_named_once_in_driving_order() -> None:
    assert a_plan().ride_ids == ("ride-0", "ride-1", "ride-2")


def a_visit(name: str, kind: VisitKind = "stop", state: VisitState = "pending") -> PlannedVisit:
    return PlannedVisit(name, kind, "", "lane", 0.0, state=state)


@pytest.mark.parametrize(
    ("visits", "ordered"),
    [
        ((a_visit("a"), a_visit("b"), a_visit("r", "rest"), a_visit("c")), "abr"),
        ((a_visit("r", "rest"), a_visit("a")), "r"),
        ((a_visit("q", "rest", "under_way"), a_visit("a"), a_visit("r", "rest"), a_visit("b")), "qar"),
        ((a_visit("a"), a_visit("b")), ""),
        ((a_visit("q", "rest", "under_way"),), ""),
    ],
)
def test_an_order_reaches_to_the_next_rest_and_no_farther(
    visits: tuple[PlannedVisit, ...], ordered: str
) -> None:
    plan = Plan("campus", "shuttle-1", 1, visits)
    assert "".join(visit.visit_id for visit in plan.ordered) == ordered
