import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.traffic.aware.conflict import clearance_m
from simulator.traffic.aware.people import AwarePeople
from simulator.traffic.aware.reaction import OWN_S, PACE
from simulator.traffic.crowd import RADIUS_M
from tests.simulator.traffic.aware.builders import DT_S, PARAMS, a_crowd, a_vehicle, a_walk, drive

NO_VEHICLES = np.zeros((0, 7))


def least_clearance_m(crowd: AwarePeople, vehicle: np.ndarray, seconds: float) -> float:
    least = np.inf
    for _ in range(round(seconds / DT_S)):
        drive(crowd, vehicle, DT_S)
        x, y = crowd.places[0]
        least = min(least, clearance_m(x, y, vehicle[0, :3], vehicle[0]))
    return least


def test_without_a_vehicle_everyone_walks_as_recorded() -> None:
    crowd = a_crowd(a_walk(1, (0.0, 0.0), (1.3, 0.0)), a_walk(2, (5.0, 3.0), (0.0, -0.8)))
    for _ in range(300):
        crowd.step(NO_VEHICLES, DT_S)
    assert crowd.places == pytest.approx(np.array(((7.8, 0.0), (5.0, -1.8))), abs=1e-6)


def test_a_vehicle_that_stays_away_changes_nothing() -> None:
    crowd = a_crowd(a_walk(1, (0.0, 0.0), (1.3, 0.0)))
    drive(crowd, a_vehicle(0.0, 12.0, 3.0), 6.0)
    assert crowd.places[0] == pytest.approx((7.8, 0.0), abs=1e-6)


def test_a_person_waits_for_a_vehicle_that_would_meet_them() -> None:
    crowd = a_crowd(a_walk(1, (10.0, -5.0), (0.0, 1.3)))
    vehicle = a_vehicle(-6.0, 0.0, 3.5)
    assert least_clearance_m(crowd, vehicle, 8.0) > 0.1


def test_the_same_person_heeding_nothing_would_be_hit() -> None:
    crowd = a_crowd(a_walk(1, (10.0, -5.0), (0.0, 1.3)), limits=np.array([[0.02, 0.0]]))
    vehicle = a_vehicle(-6.0, 0.0, 3.5)
    assert least_clearance_m(crowd, vehicle, 8.0) < 0.0


def test_a_person_passes_before_a_vehicle_that_is_far_enough() -> None:
    crowd = a_crowd(a_walk(1, (20.0, -3.0), (0.0, 1.3)))
    drive(crowd, a_vehicle(-6.0, 0.0, 3.5), 5.0)
    assert crowd.places[0] == pytest.approx((20.0, 3.5), abs=1e-6)


def test_a_person_goes_on_in_front_of_a_vehicle_that_stands() -> None:
    crowd = a_crowd(a_walk(1, (5.0, -5.0), (0.0, 1.3)))
    drive(crowd, a_vehicle(0.0, 0.0, 0.0), 7.0)
    assert crowd.places[0] == pytest.approx((5.0, 4.1), abs=1e-6)


@pytest.mark.parametrize("velocity_mps", [(0.0, 1.3), (-1.3, 0.0), (0.9, 0.9)])
def test_a_person_walks_around_a_vehicle_that_stands_on_their_way(velocity_mps: tuple[float, float]) -> None:
    start = (1.5 - 5.0 * velocity_mps[0], 0.3 - 5.0 * velocity_mps[1])
    crowd = a_crowd(a_walk(1, start, velocity_mps, lasts_s=40.0))
    vehicle = a_vehicle(0.0, 0.0, 0.0)
    assert least_clearance_m(crowd, vehicle, 25.0) > -0.01
    behind_m = np.hypot(*(crowd.places[0] - start)) - np.hypot(*velocity_mps) * 25.0
    assert behind_m > -12.0


def test_a_person_who_meets_a_vehicle_head_on_steps_aside() -> None:
    crowd = a_crowd(a_walk(1, (14.0, 0.2), (-1.2, 0.0)))
    vehicle = a_vehicle(0.0, 0.0, 1.5)
    assert least_clearance_m(crowd, vehicle, 8.0) > 0.0


def test_no_one_is_drawn_into_the_body_of_a_vehicle_that_stands_beside_them() -> None:
    crowd = a_crowd(a_walk(1, (1.0, 0.815 + RADIUS_M + 0.05), (0.0, -0.3), lasts_s=40.0))
    vehicle = a_vehicle(0.0, 0.0, 0.0)
    assert least_clearance_m(crowd, vehicle, 20.0) > -0.01


def test_a_person_who_would_appear_in_the_vehicles_place_enters_when_it_is_gone() -> None:
    late = a_walk(7, (0.5, 0.0), (0.0, 1.3))
    late = type(late)(7, late.kind, late.times_s + 1.0, late.states, late.size_m)
    crowd = a_crowd(late)
    vehicle = a_vehicle(0.0, 0.0, 0.0)
    drive(crowd, vehicle, 2.0)
    assert not crowd.present.any()
    vehicle[0, 6] = 3.0
    drive(crowd, vehicle, 3.0)
    assert crowd.present.all()
    assert crowd.delayed == {7}


def test_people_of_the_pictures_end_walk_on_and_others_are_gone() -> None:
    crowd = a_crowd(a_walk(1, (0.0, 0.0), (1.0, 0.0), 4.0), a_walk(2, (0.0, 9.0), (1.0, 0.0), 10.0))
    for _ in range(600):
        crowd.step(NO_VEHICLES, DT_S)
    assert crowd.bodies().numbers.tolist() == [2]


@settings(max_examples=40)
@given(
    speed_mps=st.floats(0.0, 6.0),
    accel_mps2=st.floats(-2.0, 1.0),
    y_m=st.floats(-4.0, 4.0),
    yaw_rad=st.floats(-0.6, 0.6),
    velocity=st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
)
def test_no_one_is_ever_ahead_of_the_recorded_time(
    speed_mps: float, accel_mps2: float, y_m: float, yaw_rad: float, velocity: tuple[float, float]
) -> None:
    crowd = a_crowd(a_walk(1, (6.0, 0.0), velocity))
    drive(crowd, a_vehicle(-4.0, y_m, speed_mps, yaw_rad), 5.0, accel_mps2)
    assert crowd.state[0, OWN_S] <= crowd.clock_s + 1e-6
    assert 0.0 <= crowd.state[0, PACE] <= 1.0


def test_slowing_down_is_no_harder_than_fitted() -> None:
    crowd = a_crowd(a_walk(1, (10.0, -4.0), (0.0, 1.3)))
    steps = drive(crowd, a_vehicle(-4.0, 0.0, 3.5), 3.0)
    speeds = np.diff([places[0, 1] for _, places in steps]) / DT_S
    decels = -np.diff(speeds) / DT_S
    assert decels.max() == pytest.approx(PARAMS.decel_mps2, rel=0.05)


def test_one_crowd_walks_twice_the_same() -> None:
    people = [a_walk(k, (4.0 + k, -5.0 + 0.3 * k), (0.1 * k, 1.2)) for k in range(8)]
    first = drive(a_crowd(*people), a_vehicle(-5.0, 0.0, 3.0), 6.0)
    second = drive(a_crowd(*people), a_vehicle(-5.0, 0.0, 3.0), 6.0)
    assert all((a == b).all() for (_, a), (_, b) in zip(first, second, strict=True))
