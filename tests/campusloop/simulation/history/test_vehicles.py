"""What the history's rules about vehicles call broken, and what not."""

from campusloop.simulation.history.records import TaskFact
from campusloop.simulation.history.vehicles import (
    FleetRules,
    dead_tasks,
    doubled_events,
    leaked_sections,
    lost_events,
    several_orders,
    stuck_outboxes,
    unreachable,
)


def test_an_order_may_not_be_taken_after_it_expired() -> None:
    rules = FleetRules(60.0)
    assert rules.accepted(62.0, "a", "order-1", 1, 0.0) is None
    expired = rules.accepted(100.0, "a", "order-1", 2, 0.0)
    assert expired is not None
    assert expired.rule == "order_expired"


def test_a_vehicle_goes_back_to_no_earlier_order_or_revision() -> None:
    rules = FleetRules(60.0)
    for order_id, revision in (("order-1", 1), ("order-1", 3), ("order-1", 3), ("order-2", 1)):
        assert rules.accepted(1.0, "a", order_id, revision, 0.0) is None
    for order_id, revision in (("order-1", 4), ("order-1", 2)):
        back = rules.accepted(1.0, "a", order_id, revision, 0.0)
        assert back is not None
        assert back.rule == "order_went_back"


def test_a_computer_that_restarts_follows_what_was_on_its_disk() -> None:
    rules = FleetRules(60.0)
    for revision in (1, 2):
        assert rules.accepted(1.0, "a", "order-1", revision, 0.0) is None
    rules.rebooted("a", "order-1", 1)
    assert rules.accepted(1.0, "a", "order-1", 2, 0.0) is None


def test_seats_sections_and_riders_belong_to_one_vehicle_and_are_not_exceeded() -> None:
    rules = FleetRules(60.0)
    assert rules.stands(1.0, "a", 6, {"ride-1": 6}, {"section-1": 1}) is None
    assert rules.stands(1.0, "b", 6, {"ride-2": 1}, {"section-2": 2}) is None
    for aboard, sections, rule in (
        ({"ride-3": 7}, {}, "seats_exceeded"),
        ({}, {"section-1": 3}, "section_shared"),
        ({"ride-1": 1}, {}, "rider_twice"),
    ):
        broken = rules.stands(2.0, "b", 6, aboard, sections)
        assert broken is not None
        assert broken.rule == rule


def test_an_event_is_stored_once() -> None:
    assert doubled_events(9.0, "a", "boot-1", [0, 1, 2]) == []
    (found,) = doubled_events(9.0, "a", "boot-1", [0, 1, 2, 1])
    assert (found.rule, found.subject) == ("event_doubled", "a")


def test_events_on_a_vehicles_disk_are_stored_as_they_were() -> None:
    assert lost_events(9.0, "a", "boot-1", {0: "x", 1: "y"}, {0: "x", 1: "y", 2: "z"}) == []
    assert [v.rule for v in lost_events(9.0, "a", "boot-1", {0: "x", 1: "y"}, {0: "x"})] == ["event_lost"]
    assert [v.rule for v in lost_events(9.0, "a", "boot-1", {0: "x"}, {0: "y"})] == ["event_changed"]


def test_a_command_is_carried_out_once() -> None:
    rules = FleetRules(60.0)
    assert rules.executed(1.0, "a", "command-1") is None
    again = rules.executed(2.0, "a", "command-1")
    assert again is not None
    assert again.rule == "command_repeated"


def test_an_event_that_stays_unacknowledged_is_a_stuck_outbox() -> None:
    before = {"a": ("boot-1", 4), "b": ("boot-1", 4)}
    assert stuck_outboxes(9.0, before, {"a": ("boot-1", 5)}) == []
    assert [v.subject for v in stuck_outboxes(9.0, before, {"b": ("boot-1", 4)})] == ["b"]


def test_a_section_that_the_vehicle_has_left_is_not_held_for_good() -> None:
    assert leaked_sections(9.0, "a", {("s1", 1)}, {("s0", 1)}) == []
    assert [v.rule for v in leaked_sections(9.0, "a", {("s1", 1)}, {("s1", 1)})] == ["section_leaked"]


def test_one_order_a_vehicle_every_vehicle_reached_and_every_task_alive() -> None:
    assert several_orders(9.0, {"a": {"order-1"}}) == []
    assert [v.subject for v in several_orders(9.0, {"a": {"order-1", "order-2"}})] == ["a"]
    assert [v.subject for v in unreachable(9.0, ["a", "b"], {"b"})] == ["a"]
    alive = TaskFact("dispatcher", True, 0, 1.0, 1.0)
    assert dead_tasks(9.0, [alive, TaskFact("reader", True, 0, None, 0.0)]) == []
    dead = [
        TaskFact("ended", False, 0, 1.0, 1.0),
        TaskFact("failing", True, 2, 1.0, 1.0),
        TaskFact("hanging", True, 0, 60.0, 1.0),
    ]
    assert [v.subject for v in dead_tasks(9.0, dead)] == ["ended", "failing", "hanging"]
