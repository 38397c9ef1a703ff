import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2
from contract.roads.model import Building
from simulator.scoring.metrics import Scorekeeper
from simulator.traffic.crowd import clearance_m
from simulator.traffic.outlines import outline_meets_edges, outlines_overlap
from simulator.vehicle.plant import PlantView

STEP_NS = 20_000_000
HALF_M, FRONT_M, REAR_M = 0.815, 3.5, 0.85
AHEAD = np.column_stack([0.5 * np.arange(121), np.zeros(121)])


def a_view(x_m: float, speed_mps: float, odometer_m: float = 0.0) -> PlantView:
    return PlantView(Pose2(x_m, 0.0, 0.0), speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0, odometer_m, 1.0)


def a_vehicle(x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0, speed_mps: float = 0.0) -> np.ndarray:
    return np.array([x_m, y_m, yaw_rad, REAR_M, FRONT_M, HALF_M, speed_mps])


class Street:
    """One vehicle on the x axis; people are put and moved by hand."""

    def __init__(self, *buildings: Building) -> None:
        self.keeper = Scorekeeper(("s1",), buildings)
        self.now_ns = 0

    @property
    def score(self):  # type: ignore[no-untyped-def]
        return self.keeper.scores["s1"]

    def step(self, x_m: float, speed_mps: float, people: list[tuple[float, float]], steps: int = 1) -> None:
        for _ in range(steps):
            self.now_ns += STEP_NS
            ahead = np.add(AHEAD, [x_m, 0.0])[None]
            places = np.array(people, dtype=float).reshape(-1, 2)
            self.keeper.step(
                self.now_ns, 0.02, [a_view(x_m, speed_mps)], a_vehicle(x_m, speed_mps=speed_mps)[None],
                ahead, places, np.arange(len(places)),
            )  # fmt: skip


def test_a_person_touching_the_outline_is_one_contact_however_long_it_lasts() -> None:
    street = Street()
    street.step(0.0, 1.0, [(FRONT_M + 0.3, 0.0)])
    assert street.score.contacts_people == 0
    street.step(0.0, 1.0, [(FRONT_M + 0.2, 0.0)], steps=30)
    assert street.score.contacts_people == 1
    street.step(0.0, 1.0, [(FRONT_M + 0.4, 0.0)])
    street.step(0.0, 1.0, [(FRONT_M + 0.2, 0.0)])
    assert street.score.contacts_people == 1
    street.step(0.0, 1.0, [(FRONT_M + 1.0, 0.0)])
    street.step(0.0, 1.0, [(FRONT_M + 0.2, 0.0)])
    assert street.score.contacts_people == 2


@pytest.mark.parametrize(
    ("place", "counts"),
    [
        ((FRONT_M + 14.9, 0.0), True),
        ((FRONT_M + 15.1, 0.0), False),
        ((FRONT_M + 5.0, HALF_M + 0.2), True),
        ((FRONT_M + 5.0, HALF_M + 0.3), False),
        ((-5.0, 0.0), False),
    ],
)
def test_an_encounter_is_a_person_in_the_swept_path_within_15_m(
    place: tuple[float, float], counts: bool
) -> None:
    street = Street()
    street.step(0.0, 2.0, [place])
    assert street.score.encounters == int(counts)


def test_one_approach_is_one_encounter_and_a_second_approach_another() -> None:
    street = Street()
    for y_m in (1.4, 0.5, 1.2, 0.5, 0.0):
        street.step(0.0, 2.0, [(12.0, y_m)])
    assert street.score.encounters == 1
    street.step(0.0, 2.0, [(12.0, 5.0)])
    street.step(0.0, 2.0, [(12.0, 0.0)])
    assert street.score.encounters == 2


def test_a_shuttle_that_has_stood_for_long_meets_nobody() -> None:
    street = Street()
    street.step(0.0, 0.0, [], steps=600)
    street.step(0.0, 0.0, [(10.0, 0.0)])
    assert street.score.encounters == 0


def test_standing_for_somebody_is_timed_and_standing_alone_is_not() -> None:
    street = Street()
    street.step(0.0, 0.0, [], steps=50)
    assert street.score.stopped_for_people_s == 0.0
    street.step(0.0, 0.0, [(8.0, 0.5)], steps=50)
    assert street.score.stopped_for_people_s == pytest.approx(1.0)


def test_the_hardest_braking_is_the_steepest_fall_of_speed() -> None:
    street = Street()
    for speed_mps in (3.0, 2.96, 2.86, 2.84):
        street.step(0.0, speed_mps, [])
    assert street.score.hardest_braking_mps2 == pytest.approx(5.0)


def test_clearance_is_measured_from_skin_to_skin_while_moving() -> None:
    street = Street()
    street.step(0.0, 0.0, [(0.0, HALF_M + 0.3)])
    assert street.score.clearance_m_min == np.inf
    street.step(0.0, 1.0, [(0.0, HALF_M + 1.0)])
    assert street.score.clearance_m_min == pytest.approx(0.75)


def test_driving_into_a_building_is_one_contact() -> None:
    street = Street(Building(((10.0, -5.0), (10.0, 5.0), (20.0, 5.0), (20.0, -5.0)), 9.0))
    street.step(5.0, 1.0, [], steps=20)
    assert street.score.contacts_buildings == 0
    street.step(7.0, 1.0, [], steps=40)
    assert street.score.contacts_buildings == 1


def test_two_shuttles_in_one_place_are_a_contact_for_each() -> None:
    keeper = Scorekeeper(("s1", "s2"), ())
    for x_m in (6.0, 4.3, 4.3):
        vehicles = np.stack([a_vehicle(), a_vehicle(x_m)])
        keeper.step(
            0, 0.02, [a_view(0.0, 1.0), a_view(x_m, 0.0)], vehicles, np.stack([AHEAD, AHEAD]),
            np.zeros((0, 2)), np.zeros(0, dtype=np.int64),
        )  # fmt: skip
    assert [score.contacts_vehicles for score in keeper.scores.values()] == [1, 1]


@given(st.floats(-12, 12), st.floats(-12, 12), st.floats(-3.2, 3.2), st.floats(-3.2, 3.2))
def test_outlines_overlap_exactly_when_a_dense_sample_of_one_meets_the_other(
    x_m: float, y_m: float, yaw_a: float, yaw_b: float
) -> None:
    a, b = a_vehicle(0.0, 0.0, yaw_a), a_vehicle(x_m, y_m, yaw_b)
    along = np.linspace(-REAR_M, FRONT_M, 88)
    across = np.linspace(-HALF_M, HALF_M, 34)
    cos, sin = np.cos(yaw_b), np.sin(yaw_b)
    nearest = min(
        clearance_m(a, x_m + cos * u - sin * v, y_m + sin * u + cos * v)
        for u in along
        for v in (across if u in (along[0], along[-1]) else across[[0, -1]])
    )
    inside = clearance_m(b, 0.0, 0.0) == 0.0 or nearest == 0.0
    if inside:
        assert outlines_overlap(a, b)
    elif nearest > 0.1 and clearance_m(b, *_centre(a)) > 0.0:
        assert not outlines_overlap(a, b)


def _centre(vehicle: np.ndarray) -> tuple[float, float]:
    middle = 0.5 * (FRONT_M - REAR_M)
    return vehicle[0] + np.cos(vehicle[2]) * middle, vehicle[1] + np.sin(vehicle[2]) * middle


def test_a_wall_that_cuts_a_corner_is_met_and_one_beside_is_not() -> None:
    vehicle = a_vehicle()
    assert outline_meets_edges(vehicle, np.array([[3.0, 0.0, 5.0, 2.0]]))
    assert not outline_meets_edges(vehicle, np.array([[3.4, 0.9, 5.0, 0.9]]))
    assert outline_meets_edges(vehicle, np.array([[1.0, -6.0, 1.0, 6.0]]))
