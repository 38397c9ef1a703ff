"""Where a shuttle rests: near, free, its own, and at a charger when it needs one."""

from dataclasses import replace

import pytest

from contract.roads.model import RestingPlace
from server.domain.errors import NoRestingPlaceFree
from server.domain.planning.plans import Plan, PlannedVisit
from server.usecases.planning import plans
from server.usecases.roads.resting import can_rest, resting_place_for, rests_at
from server.usecases.roads.road_positions import ARRIVED_M, RoadPosition
from server.usecases.roads.section_reservations import SectionReservations
from tests.server.usecases.fake_fleet import FakeFleet


def plan_of(fleet: FakeFleet, number: int) -> Plan:
    return fleet.campus.read(lambda uow: plans.plan_of(uow, fleet.shuttles[number].vehicle_id))


def chosen(
    fleet: FakeFleet, last: tuple[str, float], onward: PlannedVisit | None = None, *, charges: bool = False
) -> tuple[RestingPlace, float]:
    plan = plan_of(fleet, 0)
    return fleet.campus.read(
        lambda uow: resting_place_for(uow, plan, last, onward, SectionReservations(uow), charges=charges)
    )


def ways_s(fleet: FakeFleet, last: tuple[str, float]) -> dict[str, float]:
    places = fleet.network.resting_places
    return fleet.campus.read(
        lambda uow: {name: uow.roads().time_to_rest(last, place) for name, place in places.items()}
    )


def taken(fleet: FakeFleet) -> set[str]:
    return {plan_of(fleet, number).resting_place_id for number in range(1, len(fleet.shuttles))}


def test_the_nearest_place_that_no_other_shuttle_has_is_chosen(driven_fleet: FakeFleet) -> None:
    stop = driven_fleet.network.stops["C6"]
    last = stop.lane_id, stop.s_m
    free = {k: v for k, v in ways_s(driven_fleet, last).items() if k not in taken(driven_fleet)}
    place, way_s = chosen(driven_fleet, last)
    assert (place.place_id, way_s) == (min(free, key=lambda k: (free[k], k)), min(free.values()))


def test_on_the_way_to_another_stop_the_whole_way_round_counts(driven_fleet: FakeFleet) -> None:
    stops, roads = driven_fleet.network.stops, driven_fleet.campus.read(lambda uow: uow.roads())
    stop, goal = stops["C6"], stops["NN20"]
    last = stop.lane_id, stop.s_m
    onward = PlannedVisit("v", "stop", "NN20", goal.lane_id, goal.s_m)
    round_s = {
        name: way_s
        + float(roads.times_from_rest(driven_fleet.network.resting_places[name])[roads.stop_numbers["NN20"]])
        for name, way_s in ways_s(driven_fleet, last).items()
        if name not in taken(driven_fleet)
    }
    place, way_s = chosen(driven_fleet, last, onward)
    assert way_s == pytest.approx(min(round_s.values()))
    assert round_s[place.place_id] == pytest.approx(way_s)


def test_a_place_on_which_another_shuttle_stands_is_the_last_resort(driven_fleet: FakeFleet) -> None:
    """The other shuttle has given the place up in its plan, but still stands there."""
    other = plan_of(driven_fleet, 1)
    stood_on = driven_fleet.network.resting_places[other.resting_place_id]
    last = stood_on.lane_id, stood_on.s_m
    away = replace(other, version=other.version + 1, resting_place_id="")
    driven_fleet.campus.do(lambda uow: uow.plans.save(away, other.version))
    place, way_s = chosen(driven_fleet, last)
    assert place.place_id != stood_on.place_id
    assert way_s > ways_s(driven_fleet, last)[stood_on.place_id]


def test_without_a_place_of_its_own_a_shuttle_is_told_so(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    here = next(iter(fleet.network.resting_places.values()))
    position = RoadPosition(0, here.lane_id, here.s_m)
    plan = plan_of(fleet, 0)
    assert fleet.campus.read(lambda uow: can_rest(uow, plan, position))
    fleet.leave_homeless(plan.vehicle_id)
    assert not fleet.campus.read(lambda uow: can_rest(uow, plan, position))
    with pytest.raises(NoRestingPlaceFree, match=plan.vehicle_id):
        chosen(fleet, (here.lane_id, here.s_m))


@pytest.mark.parametrize(("off_m", "rests"), [(-1.0, True), (1.0, True), (-1.01, False), (1.01, False)])
def test_a_shuttle_rests_where_it_stands_within_the_reach_of_a_place(
    driven_fleet: FakeFleet, off_m: float, rests: bool
) -> None:
    plan = plan_of(driven_fleet, 0)
    place = driven_fleet.network.resting_places[plan.resting_place_id]
    here = place.lane_id, place.s_m + off_m * ARRIVED_M * (1.0 if abs(off_m) > 1.0 else 0.999)
    found = driven_fleet.campus.read(lambda uow: rests_at(uow, plan, here))
    assert found == (place if rests else None)
    others = plan_of(driven_fleet, 1)
    assert driven_fleet.campus.read(lambda uow: rests_at(uow, others, here)) is None
