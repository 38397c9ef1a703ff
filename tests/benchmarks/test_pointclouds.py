"""Annotated sweeps: files of many makers are read, and a bad one does not stop the others."""

import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.pointclouds.__main__ import SweepError, main, read_sweep, row_of
from benchmarks.pointclouds.annotations import AnnotationError, kind_of, read_annotations
from benchmarks.pointclouds.simulated import write_sweeps
from benchmarks.pointclouds.sweep import grid_around, judged
from tests.simulator.sensors.scene.campus import a_street
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE

HEADER = "class,x,y,z,length,width,height,yaw,track\n"


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("human.pedestrian.adult", PEDESTRIAN), ("Pedestrian", PEDESTRIAN), ("PERSON_SITTING", PEDESTRIAN),
        ("vehicle.bicycle", CYCLIST), ("Cyclist", CYCLIST), ("static_object.bicycle_rack", OTHER),
        ("vehicle.car", VEHICLE), ("Truck", VEHICLE), ("movable_object.trafficcone", OTHER), ("blob", OTHER),
    ],
)  # fmt: skip
def test_class_names_of_many_makers_are_known(name: str, kind: int) -> None:
    assert kind_of(name) == kind


def test_other_column_names_degrees_and_bad_rows(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "label;cx;cy;cz;l;w;h;heading\ncar;1;2;0;4;2;1.5;90\ncar;x;2;0;4;2;1.5;0\ncar;1;2;0;0;2;1;0\n"
    )
    boxes = read_annotations(path)
    assert boxes.kinds.tolist() == [VEHICLE]
    assert boxes.yaws[0] == pytest.approx(np.pi / 2)
    assert sum(boxes.left_out.values()) == 2


def test_what_cannot_be_read_says_why(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("")
    with pytest.raises(AnnotationError, match="is empty"):
        read_annotations(path)
    path.write_text("class,x,y\ncar,1,2\n")
    with pytest.raises(AnnotationError, match="no column z, length, width, height"):
        read_annotations(path)
    path.write_text(HEADER)
    assert len(read_annotations(path)) == 0
    lonely = tmp_path / "b.pcd"
    lonely.write_bytes(b"")
    with pytest.raises(SweepError, match=r"b\.csv is missing"):
        read_sweep(lonely)


@pytest.mark.long
def test_people_of_a_simulated_street_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_sweeps(tmp_path, a_street(), 2, "VLP-16", seed=3)
    (tmp_path / "broken.pcd").write_bytes(b"no cloud")
    (tmp_path / "broken.csv").write_text(HEADER)
    report = tmp_path / "report.json"
    monkeypatch.setattr(sys, "argv", ["pointclouds", str(tmp_path), "--json", str(report)])
    main()
    assert "left out: broken.pcd" in capsys.readouterr().err
    text = report.read_text()
    assert '"sweeps": 2' in text
    assert '"left_out": 1' in text
    results = [judged(*read_sweep(path), grid_around(2.5, 2.4)) for path in sorted(tmp_path.glob("03_*.pcd"))]
    row = row_of(results, 0.0, 30.0)
    assert float(row["obstacle_pct"] or 0.0) >= 90.0
    assert int(row["with_returns"] or 0) > 10
    assert float(row["flagged_pct"] or 100.0) < 35.0
