"""What training asks of the network is decoded to the boxes that it was made of."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.perception.pillars.decoding import DecodingParams, Detections, decoded, with_velocities
from vehicle_agent.perception.pillars.grid import PillarGrid
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE
from workshop.detector.targets import targets_of

GRID = PillarGrid(x_m_min=-12.8, y_m_min=-12.8, nx=128, ny=128)
SIZES = {PEDESTRIAN: (0.5, 0.5, 1.7), CYCLIST: (1.75, 0.6, 1.7), VEHICLE: (4.4, 1.8, 1.5)}


def answer_to(kinds: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The heat and boxes of a network that answers as it should."""
    targets = targets_of(kinds, boxes, np.full(len(kinds), 50), GRID)
    heat = np.clip(targets.heat, 1e-4, 0.95)
    shaped = targets.boxes.copy()
    shaped[9] = 2.0 * shaped[9] - 1.0
    return np.log(heat / (1.0 - heat)).astype(np.float32), shaped


@st.composite
def road_users(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Up to nine road users, 8 m apart, each somewhere in its place."""
    kinds, boxes = [], []
    for x in (-8.0, 0.0, 8.0):
        for y in (-8.0, 0.0, 8.0):
            if not draw(st.booleans()):
                continue
            kind = draw(st.sampled_from((PEDESTRIAN, CYCLIST, VEHICLE)))
            shift = draw(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)))
            yaw, speed = draw(st.floats(-3.1, 3.1)), draw(st.sampled_from((0.0, 1.5, 4.0)))
            velocity = (speed * np.cos(yaw), speed * np.sin(yaw))
            kinds.append(kind)
            boxes.append((x + shift[0], y + shift[1], yaw, *SIZES[kind], *velocity))
    return np.array(kinds, dtype=np.int64), np.array(boxes).reshape(-1, 8)


@given(users=road_users())
@settings(max_examples=20)
def test_a_right_answer_gives_the_boxes_back(users: tuple[np.ndarray, np.ndarray]) -> None:
    kinds, boxes = users
    found = decoded(*answer_to(kinds, boxes), GRID, DecodingParams())
    found = with_velocities(found, found.boxes[:, 6:8])
    assert len(found.kinds) == len(kinds)
    for kind, box in zip(kinds, boxes, strict=True):
        row = int(np.argmin(np.hypot(*(found.boxes[:, :2] - box[:2]).T)))
        assert found.kinds[row] == kind
        assert found.boxes[row, :2] == pytest.approx(box[:2], abs=1e-3)
        assert found.boxes[row, 3:] == pytest.approx(box[3:], abs=1e-3)
        # Close to the y axis the direction bit of a standing body may be either.
        if kind != PEDESTRIAN and abs(np.cos(box[2])) > 0.01:
            assert np.cos(found.boxes[row, 2] - box[2]) == pytest.approx(1.0, abs=1e-3)


def test_an_answer_that_is_not_finite_has_no_objects() -> None:
    heat, boxes = answer_to(np.array([VEHICLE]), np.array([[1.0, 1.0, 0.3, 4.4, 1.8, 1.5, 0.0, 0.0]]))
    assert len(decoded(heat, boxes, GRID, DecodingParams()).kinds) == 1
    assert len(decoded(np.full_like(heat, np.nan), boxes, GRID, DecodingParams()).kinds) == 0
    assert len(decoded(heat, np.full_like(boxes, np.nan), GRID, DecodingParams()).kinds) == 0


def test_a_hot_network_gives_at_most_as_many_objects_as_are_asked_for() -> None:
    rng = np.random.default_rng(1)
    heat = rng.normal(3.0, 0.1, (3, 64, 64)).astype(np.float32)
    boxes = np.zeros((10, 64, 64), dtype=np.float32)
    boxes[2:5] = np.log(0.2)
    params = DecodingParams(objects_max=50)
    found = decoded(heat, boxes, GRID, params)
    assert len(found.kinds) == 50
    assert (np.diff(found.scores) <= 0.0).all()


def test_what_moves_faces_the_way_it_moves_and_what_has_no_velocity_keeps_its_yaw() -> None:
    box = [0.0, 0.0, 0.3, 4.4, 1.8, 1.5, 0.0, 0.0]
    found = Detections(np.array([VEHICLE, VEHICLE, PEDESTRIAN]), np.ones(3), np.array([box, box, box]))
    velocities = np.array([[-3.0, -0.9], [np.nan, np.nan], [0.0, 1.4]])
    turned = with_velocities(found, velocities)
    assert turned.boxes[:, 2] == pytest.approx([0.3 - np.pi, 0.3, 0.5 * np.pi])
    assert np.isnan(turned.boxes[1, 6:8]).all()
