"""Training repeats from a seed, goes on after a stop as if there had been none, and gives a file to run."""

from pathlib import Path

import numpy as np
import pytest

from tests.workshop.detector.scans import a_scan
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.pillars.grid import PillarGrid, pillars_of
from workshop.detector.labeled_scans import write_scan

pytest.importorskip("torch", reason="training needs PyTorch: make training")
pytest.importorskip("onnx", reason="training needs onnx: make training")

from workshop.detector.export import exported, write_detector
from workshop.detector.training import CheckpointError, TrainingState, train
from workshop.detector.training_params import TrainingParams

GRID = PillarGrid(x_m_min=-16.0, y_m_min=-12.8, nx=160, ny=128)
PARAMS = TrainingParams(epochs=2, batch=2, seed=3)


class Stopped(Exception):
    pass


def scan_files(folder: Path, count: int = 4) -> list[Path]:
    folder.mkdir(exist_ok=True)
    for number in range(count):
        write_scan(folder / f"{number}.npz", a_scan(number))
    return [folder / f"{number}.npz" for number in range(count)]


def trained(folder: Path, checkpoint: str, stop_at: int | None = None) -> TrainingState:
    paths, steps = scan_files(folder / "scans"), 0

    def advance(done: int, losses: dict[str, float]) -> None:
        nonlocal steps
        steps += done
        if stop_at is not None and steps >= stop_at:
            raise Stopped

    return train(paths, paths[:1], GRID, PARAMS, folder / checkpoint, advance)


def weights(state: TrainingState) -> np.ndarray:
    return np.concatenate([value.detach().numpy().ravel() for value in state.network.parameters()])


def test_a_stopped_training_goes_on_as_if_it_had_not_been_stopped(tmp_path: Path) -> None:
    whole = trained(tmp_path, "whole.pt")
    with pytest.raises(Stopped):
        trained(tmp_path, "stopped.pt", stop_at=3)
    resumed = trained(tmp_path, "stopped.pt")
    assert (weights(resumed) == weights(whole)).all()
    assert resumed.losses == whole.losses
    assert whole.losses[1]["heat"] < whole.losses[0]["heat"]


def test_a_checkpoint_of_another_training_is_refused(tmp_path: Path) -> None:
    trained(tmp_path, "one.pt")
    paths = scan_files(tmp_path / "scans", 6)
    with pytest.raises(CheckpointError, match="another training"):
        train(paths, paths[:1], GRID, PARAMS, tmp_path / "one.pt", lambda steps, losses: None)
    (tmp_path / "one.pt").write_bytes(b"nothing")
    with pytest.raises(CheckpointError, match="cannot be read"):
        train(paths, paths[:1], GRID, PARAMS, tmp_path / "one.pt", lambda steps, losses: None)


def test_the_file_answers_as_the_network_and_has_its_record(tmp_path: Path) -> None:
    state = trained(tmp_path, "one.pt")
    samples = [pillars_of(scan.points, scan.is_older, GRID) for scan in (a_scan(7), a_scan(8, users=2))]
    model = exported(state.network, samples)
    assert len(model) < 3_000_000
    record = write_detector(
        tmp_path / "detector.onnx", model, state, PARAMS, 4, "scans made by hand", "a cpu"
    )
    detector = PillarDetector(tmp_path / "detector.onnx")
    assert detector.record == record
    assert detector.grid == GRID
    assert len(record.losses) == PARAMS.epochs
