"""Section grants: hold points, releases, fences."""

import pytest

from contract.wire.messages import Command, Grants, OrderAccepted, SectionGrant, SectionReleased
from tests.vehicle_agent.mission.ring import NETWORK, RingShuttle, a_visit, all_sections, an_order, rest
from vehicle_agent.mission.sections import (
    OccupiedSection,
    VehicleExtent,
    find_occupied_sections,
    movement_authority,
)

STOP = ("north", 30.0)
VISITS = (a_visit("a", *STOP), rest(STOP))
SPANS = (("a", 0.0, 20.0), ("b", 20.0, 40.0), ("c", 40.0, 60.0), ("a", 60.0, 80.0))
BODY = VehicleExtent(3.5, 0.85)


def grants(*names: str) -> tuple[SectionGrant, ...]:
    return tuple(SectionGrant(name, i + 1) for i, name in enumerate(names))


@pytest.mark.parametrize(
    ("granted", "hold_s_m", "waiting"),
    [
        ("ab", 40.0 - 4.0, "c"),
        ("ac", 20.0 - 4.0, "b"),
        ("", 0.0 - 4.0, "a"),
        ("abc", 60.0 - 4.0, "a"),
        ("abca", float("inf"), ""),
    ],
)
def test_the_bumper_stays_half_a_metre_before_the_first_section_without_a_grant(
    granted: str, hold_s_m: float, waiting: str
) -> None:
    authority = movement_authority(SPANS, grants(*granted), 5.0, BODY, 0.5)
    assert (authority.hold_s_m, authority.waiting_for) == (hold_s_m, waiting)


@pytest.mark.parametrize(
    ("granted", "s_m", "occupied"),
    [
        ("ab", 20.86, {"a": 100.0, "b": 120.0 - 0.01}),  # placed with the ground under a larger body
        ("zab", 0.9, {"z": 100.0, "a": 119.95}),  # and with the end of the lane before
        ("zab", 0.5, {"a": 120.35}),  # which the tail is still in
        ("abz", 20.86, {"a": 100.0, "b": 119.99}),  # an order that is on its way goes on there
        ("yz", 20.86, {}),  # or leads elsewhere
        ("abca", 20.86, {"a": 100.0, "b": 119.99}),  # round a loop
    ],
)
def test_a_section_that_was_granted_behind_the_tail_is_left_at_once(
    granted: str, s_m: float, occupied: dict[str, float]
) -> None:
    found = find_occupied_sections((), SPANS, grants(*granted), s_m, 100.0, BODY)
    assert {one.grant.section_id: pytest.approx(one.exit_m) for one in found} == occupied


def test_a_newer_grant_of_a_section_that_is_being_left_is_given_back_instead_of_the_old_one() -> None:
    """Its server knows the newer one alone: restored from a backup, it granted the ground once more."""
    old = OccupiedSection(SectionGrant("a", 1), 100.0)
    newer = (SectionGrant("a", 7), SectionGrant("b", 8))
    found = find_occupied_sections((old,), SPANS[:3], newer, 21.0, 100.0, BODY)
    assert [one.grant for one in found] == list(newer)


def test_a_section_that_only_the_rear_is_in_needs_no_grant() -> None:
    assert movement_authority(SPANS[:3], grants("b", "c"), 20.5, BODY, 0.5).waiting_for == ""


def test_a_shuttle_waits_for_its_grant_and_goes_on_with_it() -> None:
    shuttle = RingShuttle()
    every = all_sections(VISITS)
    shuttle.go(an_order(VISITS, sections=every[:2]))
    shuttle.run(60)
    assert shuttle.task is not None
    assert shuttle.task.waiting_for == every[2].section_id
    front_m = shuttle.task.s_m + BODY.front_m
    assert front_m == pytest.approx(40.0 - 0.5, abs=0.05)
    shuttle.step(Grants(1, "o", every))
    shuttle.run(5)
    assert shuttle.task.waiting_for == ""
    assert shuttle.task.s_m > 38.0


def test_a_grant_withdrawn_right_ahead_stops_the_shuttle_at_once() -> None:
    shuttle = RingShuttle()
    every = all_sections(VISITS)
    shuttle.go(an_order(VISITS, sections=every))
    shuttle.run(8)
    task = shuttle.step(Grants(1, "o", every[:1]))
    assert task.stop_s_m < task.s_m + 12.0
    assert task.waiting_for == every[1].section_id


def test_grants_of_another_order_are_ignored() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(VISITS))
    before = shuttle.state.memory.grants
    shuttle.step(Grants(1, "another", ()))
    assert shuttle.state.memory.grants == before


def test_every_section_is_released_once_with_its_fence_after_the_rear_has_left() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(VISITS))
    told: list[tuple[str, int]] = []
    for _ in range(1500):
        shuttle.run(0.1)
        news = [e for e in shuttle.events[len(shuttle.events) - 3 :] if isinstance(e, SectionReleased)]
        for event in news:
            if (event.section_id, event.fence) not in told:
                told.append((event.section_id, event.fence))
                section = NETWORK.sections[event.section_id]
                assert shuttle.state.place.lane_id != section.lane_id or (
                    shuttle.state.place.s_m - BODY.back_m >= section.s_to_m
                )
    released = [(e.section_id, e.fence) for e in shuttle.of(SectionReleased)]  # type: ignore[attr-defined]
    assert released == told == [(g.section_id, g.fence) for g in all_sections(VISITS)[: len(told)]]
    assert len(told) >= 7


def test_a_new_revision_cannot_bring_back_a_section_that_was_given_back() -> None:
    shuttle = RingShuttle()
    every = all_sections(VISITS)
    shuttle.go(an_order(VISITS, sections=every))
    shuttle.run_until(lambda: bool(shuttle.of(SectionReleased)))
    shuttle.step(an_order(VISITS, revision=2, sections=every))
    assert shuttle.answers[-1] == OrderAccepted(1, "o", 2)
    assert shuttle.state.memory.grants == every[1:]


def test_a_late_message_cannot_bring_back_a_released_section() -> None:
    shuttle = RingShuttle()
    every = all_sections(VISITS)
    shuttle.go(an_order(VISITS, sections=every))
    shuttle.run_until(lambda: bool(shuttle.of(SectionReleased)))
    shuttle.step(Grants(1, "o", every))
    assert every[0] not in shuttle.state.memory.grants
    shuttle.step(Grants(1, "o", (*every, SectionGrant(every[0].section_id, 99))))
    assert SectionGrant(every[0].section_id, 99) in shuttle.state.memory.grants


def test_after_a_crash_a_section_that_the_shuttle_was_pushed_out_of_is_released_once_it_drives() -> None:
    """The body may still be in it after the restart, so it is kept for the next metre."""
    shuttle = RingShuttle()
    every = all_sections(VISITS)
    shuttle.go(an_order(VISITS, sections=every))
    shuttle.run_until(lambda: every[1] in shuttle.state.memory.occupied)
    assert every[0] in shuttle.state.memory.occupied
    again = RingShuttle(shuttle.state.memory, start=("south", 30.0))
    again.step()
    again.step(Command(1, "on", "resume"))
    again.run_until(lambda: bool(again.of(SectionReleased)))
    assert again.of(SectionReleased) == [SectionReleased(every[0].section_id, every[0].fence)]
    assert 1.0 < again.state.odometer_m < 1.5
    again.run_until(lambda: len(again.of(SectionReleased)) > 1)
    assert again.of(SectionReleased)[1] == SectionReleased(every[1].section_id, every[1].fence)
