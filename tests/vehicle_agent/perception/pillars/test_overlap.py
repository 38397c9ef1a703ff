"""Overlaps are those of the polygons."""

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.perception.pillars.overlap import iou, kept_of

BOXES = st.tuples(
    st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.2, 3.2), st.floats(0.3, 6.0), st.floats(0.3, 3.0)
).map(np.array)


def polygon(box: np.ndarray) -> shapely.Polygon:
    x, y, yaw, length, width = box
    outline = shapely.box(-0.5 * length, -0.5 * width, 0.5 * length, 0.5 * width)
    turned = shapely.affinity.rotate(outline, yaw, origin=(0, 0), use_radians=True)
    return shapely.affinity.translate(turned, x, y)


@given(first=BOXES, second=BOXES)
@settings(max_examples=60)
def test_overlap_is_that_of_the_polygons(first: np.ndarray, second: np.ndarray) -> None:
    a, b = polygon(first), polygon(second)
    assert iou(first, second) == pytest.approx(a.intersection(b).area / a.union(b).area, abs=1e-6)


@given(box=BOXES)
def test_a_box_overlaps_itself_whole_also_turned_round(box: np.ndarray) -> None:
    turned = box + np.array([0.0, 0.0, np.pi, 0.0, 0.0])
    assert iou(box, box) == pytest.approx(1.0)
    assert iou(box, turned) == pytest.approx(1.0, abs=1e-6)


@given(boxes=st.lists(BOXES, max_size=12), iou_max=st.floats(0.05, 0.9))
def test_kept_boxes_do_not_overlap_and_the_others_overlap_a_better_one(
    boxes: list[np.ndarray], iou_max: float
) -> None:
    table = np.array(boxes).reshape(-1, 5)
    kept = kept_of(table, iou_max, 100).tolist()
    for row in range(len(table)):
        better = [iou(table[row], table[k]) for k in kept if k < row]
        assert (row in kept) == all(value <= iou_max for value in better)


def test_no_more_are_kept_than_asked_for() -> None:
    apart = np.array([[10.0 * k, 0.0, 0.0, 1.0, 1.0] for k in range(9)])
    assert kept_of(apart, 0.2, 4).tolist() == [0, 1, 2, 3]
