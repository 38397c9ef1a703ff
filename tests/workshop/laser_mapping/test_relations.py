"""Relations: the published benchmark's file and measure."""

import math
from pathlib import Path

import numpy as np
import pytest

from workshop.carmen.log_files import LogFileError
from workshop.laser_mapping.relations import Relations, read_relations, relation_errors

STAMPS = np.array([1.0, 1.2, 1.4])
POSES = np.array([[0.0, 0.0, math.pi / 2], [0.0, 1.0, math.pi / 2], [0.0, 2.0, math.pi]])


def test_a_line_has_stamps_translation_and_yaw(tmp_path: Path) -> None:
    path = tmp_path / "log.relations"
    path.write_text("# t1 t2 x y z roll pitch yaw\n1.0 1.2 0.5 -0.1 0 0 0 0.25\n\n1.2 1.4 1 2 3 4 5 6\n")
    relations = read_relations(path)
    assert relations.stamps_s.tolist() == [[1.0, 1.2], [1.2, 1.4]]
    assert relations.poses.tolist() == [[0.5, -0.1, 0.25], [1.0, 2.0, 6.0]]


@pytest.mark.parametrize("text", ["", "# only\n", "1 2 3\n", "1 2 3 4 5 6 7 nan\n", "a b c d e f g h\n"])
def test_a_file_of_another_kind_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "log.relations"
    path.write_text(text)
    with pytest.raises(LogFileError):
        read_relations(path)


def test_poses_that_keep_a_relation_have_no_error_wherever_they_lie() -> None:
    relations = Relations(np.array([[1.0, 1.2], [1.0, 1.4]]), np.array([[1.0, 0, 0], [2.0, 0, math.pi / 2]]))
    errors = relation_errors(relations, STAMPS, POSES + np.array([5.0, -3.0, 0.0]))
    assert errors.translations_m == pytest.approx([0.0, 0.0], abs=1e-12)
    assert errors.rotations_rad == pytest.approx([0.0, 0.0], abs=1e-12)
    assert errors.missing == 0


def test_errors_are_absolute_and_angles_wrap() -> None:
    relations = Relations(np.array([[1.2, 1.4]]), np.array([[1.3, 0.4, -3.0 * math.pi / 2 + 0.1]]))
    errors = relation_errors(relations, STAMPS, POSES)
    assert errors.translations_m == pytest.approx([0.5])
    assert errors.rotations_rad == pytest.approx([0.1])


def test_a_relation_of_other_scans_is_missing_and_stamps_need_no_order() -> None:
    relations = Relations(
        np.array([[1.0, 9.0], [1.1, 1.2], [1.2, 1.0]]), np.array([[0.0, 0, 0]] * 2 + [[-1.0, 0, 0]])
    )
    order = np.array([2, 0, 1])
    errors = relation_errors(relations, STAMPS[order], POSES[order])
    assert errors.missing == 2
    assert errors.translations_m == pytest.approx([0.0], abs=1e-12)
