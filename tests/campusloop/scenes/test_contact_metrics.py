import numpy as np
import pytest

from campusloop.scenes.contact_metrics import ContactMetrics, contact_metrics
from simulator.traffic.actors import Bodies
from vehicle_agent.config import Body
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

BODY = Body()
FRONT_M = BODY.front_overhang_m


def judged(
    *places: tuple[float, float], speed_mps: float = 2.0, kind: int = PEDESTRIAN, yaw_rad: float = 0.0
) -> ContactMetrics:
    """The vehicle stays at the origin looking along x; somebody is at each of the places in turn."""
    rows, agents = [], []
    size = (0.5, 0.5) if kind == PEDESTRIAN else (4.0, 2.0)
    for k, (x, y) in enumerate(places):
        rows.append((0.02 * k, 0.0, 0.0, 0.0, speed_mps, 0.0, 0.0))
        agents.append(
            Bodies(
                np.ones(1, np.int64),
                np.full(1, kind, np.int64),
                np.array([[x, y, yaw_rad]]),
                np.zeros((1, 2)),
                np.array([size]),
            )
        )
    return contact_metrics(np.array(rows), agents, BODY)


def test_driving_into_somebody_is_a_front_contact_counted_once() -> None:
    metrics = judged((FRONT_M + 0.5, 0.0), (FRONT_M + 0.2, 0.0), (FRONT_M + 0.1, 0.0))
    assert [number for _, number, _ in metrics.front_contacts] == [1]
    assert metrics.clearance_m == pytest.approx(-0.15)


def test_standing_or_creeping_it_is_not_its_doing() -> None:
    metrics = judged((FRONT_M + 0.5, 0.0), (FRONT_M + 0.2, 0.0), speed_mps=0.2)
    assert not metrics.front_contacts
    assert len(metrics.other_contacts) == 1


def test_who_walks_into_the_flank_is_counted_apart() -> None:
    half_m = 0.5 * BODY.width_m
    metrics = judged((1.0, half_m + 0.5), (1.0, half_m + 0.2))
    assert not metrics.front_contacts
    assert len(metrics.other_contacts) == 1


def test_who_comes_back_is_a_new_contact() -> None:
    metrics = judged((FRONT_M + 0.2, 0.0), (FRONT_M + 0.5, 0.0), (FRONT_M + 0.2, 0.0))
    assert len(metrics.front_contacts) == 2


def test_a_clearance_is_to_the_persons_edge() -> None:
    assert judged((FRONT_M + 1.0, 0.0)).clearance_m == pytest.approx(0.75)


def test_a_car_across_the_bumper_is_met_although_its_corners_are_far_away() -> None:
    metrics = judged((FRONT_M + 0.9, 0.0), kind=VEHICLE, yaw_rad=np.pi / 2)
    assert len(metrics.front_contacts) == 1
