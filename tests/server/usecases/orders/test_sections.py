"""How much road a shuttle is granted, and when it gets none."""

from collections.abc import Callable

import pytest

from contract.geometry import Pose2
from server.usecases.orders import sections
from server.usecases.roads.section_reservations import SectionReservations
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle


def driving(fleet: FakeFleet) -> FakeShuttle:
    """A shuttle on its way to a ride, after its first grants."""
    ride = fleet.book("NN20", "C6")
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    fleet.campus.do(sections.extend_grants)
    return shuttle


def held_m(fleet: FakeFleet, shuttle: FakeShuttle) -> float:
    """Road granted ahead of the rear axle."""
    held = fleet.campus.read(lambda uow: SectionReservations(uow).occupancy(shuttle.vehicle_id)).held_ids
    lengths = [fleet.network.sections[s].s_to_m - fleet.network.sections[s].s_from_m for s in held]
    first = fleet.network.sections[held[0]]
    behind = shuttle.place.s_m - first.s_from_m if first.lane_id == shuttle.place.lane_id else 0.0
    return sum(lengths) - behind


def test_a_shuttle_gets_at_least_the_road_of_the_rules_and_little_more(driven_fleet: FakeFleet) -> None:
    shuttle = driving(driven_fleet)
    longest_m = max(s.s_to_m - s.s_from_m for s in driven_fleet.network.sections.values())
    rule_m = driven_fleet.campus.rules.grant_ahead_m
    assert rule_m <= held_m(driven_fleet, shuttle) <= sections.ALONE_FACTOR * rule_m + longest_m
    assert driven_fleet.campus.do(sections.extend_grants) == (), "it has what it should have"


def beside_another(fleet: FakeFleet) -> FakeShuttle:
    """`driving`, with the other shuttle just near enough for the normal length of road."""
    shuttle, other = fleet.shuttles
    put_away_from(shuttle, other, sections.ALONE_M)
    assert driving(fleet) is shuttle
    return shuttle


def put_away_from(shuttle: FakeShuttle, other: FakeShuttle, distance_m: float) -> None:
    here = shuttle.status().pose_map
    other.astray = Pose2(here.x_m + distance_m, here.y_m, 0.0)
    other.report()


def test_a_shuttle_far_from_all_others_gets_twice_as_much_road(driven_fleet: FakeFleet) -> None:
    shuttle = beside_another(driven_fleet)
    near_m = held_m(driven_fleet, shuttle)
    put_away_from(shuttle, driven_fleet.shuttles[1], sections.ALONE_M + 0.1)
    assert driven_fleet.campus.do(sections.extend_grants) == (shuttle.vehicle_id,)
    rule_m = driven_fleet.campus.rules.grant_ahead_m
    assert rule_m <= near_m < sections.ALONE_FACTOR * rule_m <= held_m(driven_fleet, shuttle)


@pytest.mark.parametrize("stop", [FakeShuttle.hold, FakeShuttle.disconnect])
def test_a_shuttle_that_is_held_or_out_of_reach_gets_no_more_road(
    driven_fleet: FakeFleet, stop: Callable[[FakeShuttle], None]
) -> None:
    """Others may need the road before it drives again."""
    shuttle = beside_another(driven_fleet)
    before_m = held_m(driven_fleet, shuttle)
    put_away_from(shuttle, driven_fleet.shuttles[1], sections.ALONE_M + 0.1)
    stop(shuttle)
    driven_fleet.campus.do(sections.extend_grants)
    assert held_m(driven_fleet, shuttle) == before_m
    shuttle.recover()
    driven_fleet.campus.do(sections.extend_grants)
    assert held_m(driven_fleet, shuttle) > before_m


def test_only_the_grant_in_force_gives_a_section_back_and_the_last_one_is_kept(
    driven_fleet: FakeFleet,
) -> None:
    shuttle = driving(driven_fleet)
    name = shuttle.vehicle_id
    held = driven_fleet.campus.read(lambda uow: sections.grants_of(uow, name))
    assert len(held) > 1
    first = held[0]
    driven_fleet.campus.do(lambda uow: sections.released(uow, name, first.section_id, first.fence + 1000))
    still = driven_fleet.campus.read(lambda uow: sections.grants_of(uow, name))
    assert first in still
    assert not driven_fleet.campus.do(
        lambda uow: SectionReservations(uow).release(name, first.section_id, first.fence + 1000)
    )
    driven_fleet.campus.do(lambda uow: sections.released(uow, name, first.section_id, first.fence))
    assert first not in driven_fleet.campus.read(lambda uow: sections.grants_of(uow, name))
    for grant in driven_fleet.campus.read(lambda uow: sections.grants_of(uow, name))[:-1]:
        driven_fleet.campus.do(
            lambda uow, g=grant: SectionReservations(uow).release(name, g.section_id, g.fence)  # type: ignore[misc]
        )
    (last,) = driven_fleet.campus.read(lambda uow: sections.grants_of(uow, name))
    assert not driven_fleet.campus.do(
        lambda uow: SectionReservations(uow).release(name, last.section_id, last.fence)
    )
