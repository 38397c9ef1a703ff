"""Whatever words and presses come in whatever order, the story told stays consistent."""

from typing import Any

import msgspec
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from contract.runlog.arrays import dec_hook, enc_hook
from contract.wire.messages import (
    Command,
    Grants,
    PassengerTap,
    RiderAlighted,
    RiderBoarded,
    RiderNoShow,
    RiderTask,
    SectionReleased,
    VisitChanged,
)
from tests.vehicle_agent.mission.ring import RingShuttle, a_visit, all_sections, an_order, rest
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import CodeTyped, SeatButton, SeatSensor

ANN, BOB = RiderTask("ann", 1, "1111"), RiderTask("bob", 2, "2222")
ON, OFF, FAR = ("south", 30.0), ("north", 20.0), ("south", 60.0)
FIRST = (a_visit("on", *ON, board=(ANN, BOB)), a_visit("off", *OFF, ON, alight=(ANN, BOB)), rest(OFF))
SECOND = (
    a_visit("on", *ON, board=(ANN, BOB)),
    a_visit("far", *FAR, ON),
    a_visit("off", *OFF, FAR, alight=(ANN, BOB)),
    rest(OFF),
)
RANK = {"pending": 0, "under_way": 1, "done": 2, "skipped": 2}

SAID = st.one_of(
    st.sampled_from([an_order(FIRST), an_order(SECOND, 2), an_order(FIRST, 3), an_order(SECOND, 1, "other")]),
    st.builds(lambda n, o: Grants(1, o, all_sections(SECOND)[:n]), st.integers(0, 9), st.sampled_from("ox")),
    st.builds(
        lambda i, k: Command(1, f"c{i}", k),
        st.integers(0, 9),
        st.sampled_from(["hold", "resume", "stop_now"]),
    ),
    st.builds(
        lambda i, r, k: PassengerTap(1, f"t{i}", r, k),
        st.integers(0, 9),
        st.sampled_from(["ann", "bob", "eve"]),
        st.sampled_from(["board", "alight"]),
    ),
    st.builds(lambda seat: SeatButton(0, seat), st.integers(0, 5)),
    st.builds(lambda code: CodeTyped(0, code), st.sampled_from(["1111", "2222", "", "x"])),
    st.builds(lambda n: SeatSensor(0, n), st.integers(0, 6)),
)
STORY = st.lists(st.tuples(st.floats(0.0, 12.0), SAID), min_size=3, max_size=14)


def told(shuttle: RingShuttle) -> None:
    """The claims about everything said so far."""
    boarded, gone, missed = [], [], []
    rank: dict[str, int] = {}
    released: list[tuple[str, int]] = []
    for event in shuttle.events:
        if isinstance(event, RiderBoarded):
            boarded.append(event.ride_id)
            assert event.ride_id not in missed
        elif isinstance(event, RiderAlighted):
            assert event.ride_id in boarded
            gone.append(event.ride_id)
        elif isinstance(event, RiderNoShow):
            assert event.ride_id not in boarded
            missed.append(event.ride_id)
        elif isinstance(event, VisitChanged):
            assert RANK[event.state] > rank.get(event.visit_id, 0), "a visit never goes backwards"
            rank[event.visit_id] = RANK[event.state]
        elif isinstance(event, SectionReleased):
            released.append((event.section_id, event.fence))
    for ids in (boarded, gone, missed, released):
        assert len(set(ids)) == len(ids), "everything happens once"
    assert {rider.ride_id for rider in shuttle.state.memory.aboard} == set(boarded) - set(gone)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(STORY)
def test_any_story_is_consistent_and_never_crashes(story: list[tuple[float, Any]]) -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order(FIRST, sections=all_sections(SECOND)))
    for seconds, said in story:
        shuttle.run(seconds)
        shuttle.step(said)
        assert not (shuttle.doors_open and shuttle.speed_mps > 0.0)
    shuttle.run(5)
    told(shuttle)


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(STORY)
def test_a_message_repeated_at_once_is_harmless(story: list[tuple[float, Any]]) -> None:
    once, twice = RingShuttle(), RingShuttle()
    for shuttle in (once, twice):
        shuttle.go(an_order(FIRST, sections=all_sections(SECOND)))
    for seconds, said in story:
        if isinstance(said, SeatSensor | CodeTyped | SeatButton):
            continue
        for shuttle in (once, twice):
            shuttle.run(seconds)
        once.step(said)
        twice.step(said, said)
    assert [e for e in once.events if isinstance(e, RiderBoarded | RiderAlighted | VisitChanged)] == [
        e for e in twice.events if isinstance(e, RiderBoarded | RiderAlighted | VisitChanged)
    ]


@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(STORY, st.integers(0, 13))
def test_a_saved_and_restored_mission_continues_identically(story: list[tuple[float, Any]], at: int) -> None:
    kept, restored = RingShuttle(), RingShuttle()
    for shuttle in (kept, restored):
        shuttle.go(an_order(FIRST, sections=all_sections(SECOND)))
    for i, (seconds, said) in enumerate(story):
        for shuttle in (kept, restored):
            shuttle.run(seconds)
            shuttle.step(said)
        if i == at:
            data = msgspec.msgpack.encode(restored.state, enc_hook=enc_hook)
            restored.state = msgspec.msgpack.decode(data, type=MissionState, dec_hook=dec_hook)
        assert kept.events == restored.events
        assert kept.pose == restored.pose
