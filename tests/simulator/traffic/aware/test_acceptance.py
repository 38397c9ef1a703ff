"""People heed the shuttle as they heeded the car: what they accepted of it, they accept of the shuttle."""

import numpy as np
import pytest

from contract.geometry import Array
from simulator.traffic.aware.acceptance import accepted_limits
from simulator.traffic.aware.reproduction import Outline, reproduction, walk
from simulator.traffic.aware.traffic import AwareTraffic
from simulator.traffic.aware.ways import own_ways
from simulator.traffic.recordings import CARS_FROM, Clip, RecordedTrack
from tests.simulator.traffic.aware.builders import DT_S, PARAMS, a_vehicle, a_walk
from vehicle_agent.signals import VEHICLE

OUTLINE: Outline = (2.25, 2.25, 0.9)


def a_car(x_m: float, speed_mps: float, lasts_s: float = 8.0, y_m: float = 0.0) -> RecordedTrack:
    times = np.arange(0.0, lasts_s, 0.04)
    x = x_m + speed_mps * times
    still = np.zeros_like(times)
    states = np.column_stack((x, still + y_m, still, still + speed_mps, still))
    return RecordedTrack(CARS_FROM, VEHICLE, times, states, (4.5, 1.8), 0)


def a_clip(*tracks: RecordedTrack) -> Clip:
    return Clip("clip", tracks, max(float(track.times_s[-1]) for track in tracks))


def limits_of(clip: Clip) -> Array:
    people = [track for track in clip.tracks if not track.is_driven]
    return accepted_limits(own_ways([(p.times_s, p.states) for p in people]), clip.cars(), PARAMS)


def test_a_person_who_never_met_a_car_has_the_fitted_limits() -> None:
    limits = limits_of(a_clip(a_walk(1, (0.0, 20.0), (1.3, 0.0)), a_car(0.0, 3.0)))
    assert limits[0] == pytest.approx(PARAMS.limits(1)[0])


def test_a_person_whom_the_car_passed_closely_accepts_that_of_the_shuttle() -> None:
    limits = limits_of(a_clip(a_walk(1, (8.0, 0.9 + 0.25 + 0.1), (0.1, 0.0)), a_car(0.0, 3.0)))
    assert limits[0, 0] < 0.1


def test_a_person_for_whom_the_car_braked_late_reacts_as_late_to_the_shuttle() -> None:
    crossing = a_walk(1, (12.0, -4.0), (0.0, 1.3), 8.0)
    braking = a_car(0.0, 3.0, 2.4)
    stands = a_car(7.2, 0.0)
    car = RecordedTrack(
        CARS_FROM,
        VEHICLE,
        np.concatenate((braking.times_s, 2.4 + stands.times_s)),
        np.vstack((braking.states, stands.states)),
        (4.5, 1.8),
        0,
    )
    assert limits_of(a_clip(crossing, car))[0, 1] < PARAMS.notice_s - 0.3


@pytest.mark.parametrize("before_s", [0.3, 0.7, 1.2])
def test_people_who_dared_before_the_car_dare_it_before_the_shuttle(before_s: float) -> None:
    car = a_car(0.0, 3.0)
    clears_at_s = (12.0 - 2.25) / 3.0 - before_s
    person = a_walk(1, (12.0, 0.9 + 0.25 - 1.3 * clears_at_s), (0.0, 1.3), 8.0)
    found = reproduction(a_clip(person, car), car, OUTLINE, PARAMS)
    assert found.deployed_m.max() < 0.01


def test_a_person_who_waited_is_recreated_better_than_by_one_who_heeds_nothing() -> None:
    car = a_car(-3.0, 3.0)
    going, waiting = a_walk(1, (12.0, -6.0), (0.0, 1.3), 3.0), 2.0
    after = going.states.copy()
    after[:, 1] += going.states[-1, 1] - going.states[0, 1]
    still = going.states[-1].copy()
    still[3:5] = 0.0
    stands_s = np.arange(3.1, 3.0 + waiting, 0.1)
    times = np.concatenate((going.times_s, stands_s, 3.0 + waiting + going.times_s))
    states = np.vstack((going.states, np.tile(still, (len(stands_s), 1)), after))
    person = RecordedTrack(1, going.kind, times, states, going.size_m)
    found = reproduction(a_clip(person, car), car, OUTLINE, PARAMS)
    assert found.unheeding_m.mean() > 0.3
    assert found.recreated_m.mean() < 0.6 * found.unheeding_m.mean()


def test_the_vehicle_that_comes_later_than_the_car_is_waited_for() -> None:
    car = a_car(0.0, 3.0)
    person = a_walk(1, (12.0, -7.2), (0.0, 1.2), 12.0)
    ways = own_ways([(person.times_s, person.states)])
    late = walk([person], ways, PARAMS.limits(1), PARAMS, car, 12.0, OUTLINE, late_s=2.0)
    assert late.paces.min() < 0.5


def test_recorded_cars_go_on_as_recorded_and_people_heed_the_shuttle() -> None:
    clip = a_clip(a_walk(1, (10.0, -5.0), (0.0, 1.3)), a_car(0.0, 3.0, y_m=30.0))
    traffic = AwareTraffic(clip, 0.0)
    vehicle = a_vehicle(-6.0, 0.0, 3.5)
    for _ in range(150):
        vehicle[0, 0] += 3.5 * DT_S
        traffic.step(vehicle, np.zeros(1), np.zeros((1, 1, 2)), DT_S)
    bodies = traffic.bodies()
    assert bodies.numbers.tolist() == [1, CARS_FROM]
    assert bodies.poses_map[1, 0] == pytest.approx(9.0, abs=1e-6)
    assert bodies.poses_map[0, 1] < -1.2


def test_held_people_neither_move_nor_show() -> None:
    traffic = AwareTraffic(a_clip(a_walk(1, (10.0, -5.0), (0.0, 1.3))), 0.0)
    traffic.hold = True
    traffic.step(np.zeros((0, 7)), np.zeros(0), np.zeros((0, 1, 2)), DT_S)
    assert not len(traffic.bodies().numbers)
    traffic.hold = False
    assert traffic.bodies().poses_map[0, :2] == pytest.approx((10.0, -5.0))


def test_a_clip_without_people_is_empty_and_has_no_displacements() -> None:
    car = a_car(0.0, 3.0)
    traffic = AwareTraffic(a_clip(car), 0.0, frozenset({car.number}))
    traffic.step(a_vehicle(0.0, 0.0, 1.0), np.zeros(1), np.zeros((1, 1, 2)), DT_S)
    assert not len(traffic.bodies().numbers)
    found = reproduction(a_clip(car), car, OUTLINE, PARAMS)
    assert not len(found.deployed_m) + len(found.recreated_m)


def test_a_person_who_was_seen_once_is_shown_once() -> None:
    person = a_walk(1, (10.0, -5.0), (0.0, 1.3), 0.0)
    traffic = AwareTraffic(a_clip(person, a_car(0.0, 3.0, y_m=30.0)), 0.0)
    assert traffic.bodies().numbers.tolist() == [1, CARS_FROM]
    for _ in range(10):
        traffic.step(a_vehicle(-20.0, 0.0, 1.0), np.zeros(1), np.zeros((1, 1, 2)), DT_S)
    assert traffic.bodies().numbers.tolist() == [CARS_FROM]
