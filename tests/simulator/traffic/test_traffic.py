import numpy as np
import pytest

from simulator.traffic.crowd import KERB, X, Y
from simulator.traffic.population import TrafficParams
from simulator.world import WorldOptions
from tests.simulator.street import a_world
from tests.simulator.traffic.careful_driver import CarefulDriver


def people_on(options: TrafficParams, seed: int = 1, x_m: float = 20.0) -> CarefulDriver:
    return CarefulDriver(a_world(WorldOptions(traffic=options, lidar=False), seed=seed, x_m=x_m))


NOBODY_ELSE = TrafficParams(meeting_m=(1e6, 2e6), strollers_per_100m=0.0)


def an_empty_street() -> CarefulDriver:
    """People exist only where the test puts them."""
    driver = people_on(NOBODY_ELSE)
    driver.drive(0.5)
    crowd = driver.world.pedestrians
    assert crowd is not None
    crowd.population.keep(np.zeros(len(crowd.places), dtype=bool))
    crowd._encounter_at_m[:] = [1e6]
    crowd._stroller_at_m[:] = [1e6]
    return driver


@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.long) for k in (2, 3))])
def test_a_ride_of_500_m_meets_five_people_and_touches_nobody(seed: int) -> None:
    driver = people_on(TrafficParams(), seed)
    driver.drive(260.0)
    score = driver.world.score("s1")
    assert score.distance_m > 450.0
    assert score.encounters >= 5 * score.distance_m / 500.0
    assert score.contacts == 0
    assert score.stopped_for_people_s > 0.0


def test_the_same_seed_brings_the_same_people_and_another_seed_others() -> None:
    places = []
    for seed in (5, 5, 6):
        driver = people_on(TrafficParams(), seed)
        driver.drive(40.0)
        crowd = driver.world.pedestrians
        assert crowd is not None
        places.append(crowd.places.tobytes())
    assert places[0] == places[1] != places[2]


def test_somebody_in_the_way_of_a_waiting_shuttle_clears_the_path_after_four_to_eight_seconds() -> None:
    driver = an_empty_street()
    crowd = driver.world.pedestrians
    assert crowd is not None
    crowd.population.place(45.0, 0.2)
    waited_s = 0.0
    while abs(crowd.places[0, 1]) < 2.0:
        driver.drive(0.1)
        waited_s += 0.1 if driver.world.truth("s1").speed_mps < 1.2 else 0.0
        assert waited_s < 20.0
    assert waited_s > 4.0
    driver.drive(20.0)
    assert driver.world.truth("s1").pose_map.x_m > 60.0
    assert driver.world.score("s1").contacts == 0


def test_nobody_steps_in_front_of_a_moving_shuttle_nearer_than_the_look() -> None:
    """A blind shuttle passes people at the kerb: those who step out do so with room to stop."""
    driver = CarefulDriver(
        a_world(WorldOptions(traffic=TrafficParams(strollers_per_100m=0.0), lidar=False)), blind=True
    )
    crowd = driver.world.pedestrians
    assert crowd is not None
    outside: dict[int, bool] = {}
    stepped = 0
    for _ in range(6000):
        driver.drive(0.02)
        truth = driver.world.truth("s1")
        bumper_m = truth.pose_map.x_m + 3.5
        for number, (x, y) in zip(crowd.numbers.tolist(), crowd.places.tolist(), strict=True):
            inside = abs(y) < 0.815 + 0.25
            if inside and outside.get(number, False) and 0.0 < x - bumper_m < 40.0:
                stepped += 1
                assert x - bumper_m > 5.0
            outside[number] = not inside
        if truth.pose_map.x_m > 400.0:
            break
    assert stepped >= 3


def test_somebody_walking_head_on_walks_around_a_standing_shuttle() -> None:
    driver = an_empty_street()
    crowd = driver.world.pedestrians
    assert crowd is not None
    driver.world.module("s1").stop_pressed = True
    crowd.population.place(40.0, 0.1, ((10.0, 0.1),))
    driver.drive(25.0)
    assert abs(crowd.places[0, 1]) > 0.815 + 0.25 or len(crowd.places) == 0
    assert driver.world.score("s1").contacts == 0


def test_somebody_crossing_where_a_shuttle_stands_walks_around_it() -> None:
    driver = an_empty_street()
    crowd = driver.world.pedestrians
    assert crowd is not None
    driver.world.module("s1").stop_pressed = True
    driver.drive(1.0)
    x_m = driver.world.truth("s1").pose_map.x_m
    crowd.population.place(x_m + 2.5, 3.5, ((x_m + 2.5, -4.0),))
    driver.drive(20.0)
    assert crowd.places[0, 1] == pytest.approx(-4.0, abs=0.4)
    assert driver.world.score("s1").contacts == 0


def test_people_are_forgotten_far_from_every_shuttle() -> None:
    driver = an_empty_street()
    crowd = driver.world.pedestrians
    assert crowd is not None
    crowd.population.place(300.0, 5.0)
    crowd.population.place(50.0, 5.0)
    driver.drive(0.5)
    assert crowd.places.tolist() == [[50.0, 5.0]]


def test_a_reckless_person_steps_out_at_any_distance() -> None:
    """The scenario that the look protects from: without it, people do step out close to the bumper."""
    params = TrafficParams(strollers_per_100m=0.0, reckless=True, trigger_m=(2.0, 4.0))
    driver = CarefulDriver(a_world(WorldOptions(traffic=params, lidar=False)), blind=True)
    crowd = driver.world.pedestrians
    assert crowd is not None
    nearest_m = np.inf
    for _ in range(5000):
        driver.drive(0.02)
        bumper_m = driver.world.truth("s1").pose_map.x_m + 3.5
        walking = crowd.population.activity != KERB
        inside = walking & (np.abs(crowd.population.people[:, Y]) < 1.065)
        gaps_m = crowd.population.people[inside, X] - bumper_m
        nearest_m = min(nearest_m, float(gaps_m[gaps_m > 0.0].min(initial=np.inf)))
    assert nearest_m < 4.0
