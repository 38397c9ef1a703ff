"""The slowest tick's times are told once, room by room."""

from dataclasses import fields

from tests.contract.roads.ring_map import ring_map
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.tick import tick
from vehicle_agent.runtime.room_times import ROOMS, TickStopwatch
from vehicle_agent.signals import Inputs
from vehicle_agent.stacks.gem import gem


def test_every_room_is_timed_and_the_tick_gives_the_same() -> None:
    car = gem(Profile(), ring_map())
    assert set(ROOMS) == {field.name for field in fields(car)}
    watch = TickStopwatch()
    timed = watch.timed(car)
    _, expected = tick(initial_state(car), Inputs(1_000), car)
    _, outputs = tick(initial_state(timed), Inputs(1_000), timed)
    assert (outputs.report, outputs.frames) == (expected.report, expected.frames)
    watch.note(whole_ns=10**12, late_ns=-5)
    times = watch.take()
    assert times is not None
    assert [one.room for one in times.rooms] == list(ROOMS)
    assert (times.whole_us, times.late_us) == (10**9, 0)
    assert watch.take() is None


def test_of_several_ticks_the_slowest_is_told() -> None:
    watch = TickStopwatch()
    for whole_ns, late_ns in ((2_000_000, 1_000), (9_000_000, 2_000), (3_000_000, 3_000)):
        watch.note(whole_ns, late_ns)
    times = watch.take()
    assert times is not None
    assert (times.whole_us, times.late_us) == (9_000, 2)
