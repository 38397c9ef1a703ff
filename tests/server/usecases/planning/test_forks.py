"""A fork of the past: it begins with what was so then, repeats, and shows what a change would have done."""

import asyncio
import pickle
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest

from server.domain.errors import ForkImpossible, ForksBusy, ForkStopped, ForkUnknown
from server.domain.rides.rides import RideState
from server.loops.forks import FORKS_MAX, InlineForks, ProcessForks
from server.usecases.planning.forks import ForkInput, ForkResult, fork_input, run_fork
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map


@pytest.fixture(scope="module")
def drive() -> Iterator[tuple[FakeFleet, datetime]]:
    """Rides, one of which is on board at the moment that is given, and others that are wanted later.

    Forks change nothing: all tests look at the same drive.
    """
    campus = CampusUnderTest(shipped_map("snow-lion"))
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 2).start()
    stops = [stop.stop_id for stop in fleet.network.road_map.stops]
    first = fleet.book(stops[0], stops[4])
    waiting = [fleet.book(stops[k], stops[k + 3]) for k in (1, 2)]
    for _ in range(2000):
        if fleet.ride(first.ride_id).state is RideState.ABOARD:
            break
        fleet.step()
    moment = fleet.campus.clock.now()
    fleet.step()
    later = [fleet.book(stops[k], stops[(k + 5) % len(stops)]) for k in range(4)]
    for _ in range(4000):
        if all(fleet.ride(ride.ride_id).state is RideState.COMPLETED for ride in (first, *waiting, *later)):
            break
        fleet.step()
    yield fleet, moment
    campus.close()


def forked(
    fleet: FakeFleet, moment: datetime, more: int = 0, policy: str = "improvement", hours: float = 3.0
) -> ForkInput:
    until = moment + timedelta(hours=hours)
    return fleet.campus.read(lambda uow: fork_input(uow, moment, until, more, policy))


def test_a_fork_has_the_rides_that_waited_and_came_and_shuttles_where_they_were(
    drive: tuple[FakeFleet, datetime],
) -> None:
    fleet, moment = drive
    fork = forked(fleet, moment)
    aboard = [
        ride
        for ride in fleet.rides()
        if ride.boarded_at is not None and ride.boarded_at <= moment and (ride.ended_at or moment) > moment
    ]
    assert len(aboard) >= 1
    assert {ride.ride for ride in fork.rides}.isdisjoint(ride.ride_id for ride in aboard)
    assert len(fork.rides) + len(aboard) + sum(
        ride.ended_at is not None and ride.ended_at <= moment for ride in fleet.rides()
    ) == len(fleet.rides())
    assert all(ride.announced_at >= moment for ride in fork.rides)
    assert {start.vehicle_id for start in fork.starts} == {"shuttle-1", "shuttle-2"}
    # The shuttle with riders on board is free when the last of them has got out, at that stop.
    busy = {ride.vehicle_id: ride for ride in sorted(aboard, key=lambda ride: str(ride.ended_at))}
    for start in fork.starts:
        if start.vehicle_id in busy:
            ride = busy[start.vehicle_id]
            assert ride.ended_at is not None
            assert start.ready_s == ride.ended_at.timestamp()
            stop = next(s for s in fleet.network.road_map.stops if s.stop_id == ride.to_stop)
            assert (start.lane_id, start.s_m) == (stop.lane_id, stop.s_m)
        else:
            assert start.ready_s == moment.timestamp()


def test_the_same_fork_comes_out_again_and_without_a_change_both_sides_are_equal(
    drive: tuple[FakeFleet, datetime],
) -> None:
    fleet, moment = drive
    fork = forked(fleet, moment)
    result = run_fork(fork)
    assert run_fork(pickle.loads(pickle.dumps(fork))) == result
    assert result.present == result.changed
    assert result.present.asked == len(fork.rides) == result.present.served + result.present.refused
    # What had been promised at the moment is served.
    waits = [ride.present_wait_s for ride in result.rides if ride.present_wait_s is not None]
    assert result.present.wait_median_s == pytest.approx(float(np.median(waits)), abs=0.1)
    ends = {ride.ride_id: ride.present_end for ride in result.rides}
    promised = [ride.ride for ride in fork.rides if ride.promised]
    assert promised
    assert {ends[ride] for ride in promised} == {"served"}
    for ride in result.rides:
        assert (ride.present_end, ride.present_wait_s) == (ride.changed_end, ride.changed_wait_s)
        assert ride.then_wait_s is not None
        assert ride.then_wait_s >= 0.0


def test_with_more_shuttles_people_wait_less_and_with_fewer_longer(
    drive: tuple[FakeFleet, datetime],
) -> None:
    fleet, moment = drive

    def waited(result: ForkResult) -> float:
        """A refused ride counts as one that waits for an hour."""
        waits = [ride.changed_wait_s for ride in result.rides]
        return sum(3600.0 if wait_s is None else wait_s for wait_s in waits)

    less, same, more = (waited(run_fork(forked(fleet, moment, more=n))) for n in (-1, 0, 3))
    assert less >= same >= more
    assert less > more


def test_a_moment_without_rides_and_a_fleet_without_shuttles_are_refused(
    drive: tuple[FakeFleet, datetime],
) -> None:
    fleet, moment = drive
    for change in ({"more": -2}, {"more": 500}):
        with pytest.raises(ForkImpossible):
            forked(fleet, moment, **change)
    with pytest.raises(ForkImpossible):
        forked(fleet, moment + timedelta(days=3))


def test_a_child_process_gives_the_same_and_takes_only_so_many(
    drive: tuple[FakeFleet, datetime],
) -> None:
    fleet, moment = drive
    fork = replace(forked(fleet, moment), policy="insertion")

    async def compare() -> None:
        forks = ProcessForks()
        try:
            here = await InlineForks().run(fork, "")
            running = [asyncio.ensure_future(forks.run(fork, "")) for _ in range(FORKS_MAX)]
            await asyncio.sleep(0)
            with pytest.raises(ForksBusy):
                await forks.run(fork, "")
            found = await asyncio.gather(*running)
            assert [replace(one, computing_s=0.0) for one in found] == [here] * FORKS_MAX
            assert min(one.computing_s for one in found) > 0.0
        finally:
            forks.close()

    asyncio.run(compare())


def test_a_fork_is_stopped_while_it_waits_and_while_it_is_computed(drive: tuple[FakeFleet, datetime]) -> None:
    fleet, moment = drive
    fork = replace(forked(fleet, moment), policy="insertion")

    async def stop() -> None:
        forks = ProcessForks()
        try:
            first, second, third = (
                asyncio.ensure_future(forks.run(fork, name)) for name in ("first", "second", "third")
            )
            await asyncio.sleep(0)
            forks.stop("second")
            forks.stop("first")
            for one in (first, second):
                with pytest.raises(ForkStopped):
                    await one
            with pytest.raises(ForkUnknown):
                forks.stop("first")
            assert (await third).rides, "those that wait have a child of their own"
            again = asyncio.ensure_future(forks.run(fork, "again"))
            await forks.computing.wait()
            forks.stop("again")
            with pytest.raises(ForkStopped):
                await again
            assert (await forks.run(fork, "")).rides
        finally:
            forks.close()

    asyncio.run(stop())
