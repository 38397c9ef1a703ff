"""Run logs of benchmark drives, and the picture of one."""

import argparse
from pathlib import Path

import numpy as np
import pytest

from benchmarks.reporting.run_logs import LogChoice, add_log_arguments, log_choice
from benchmarks.reporting.run_plot import clearance_over_time, plot
from vehicle_agent.config import Body
from vehicle_agent.signals import PEDESTRIAN


def chosen(*words: str) -> LogChoice:
    parser = argparse.ArgumentParser()
    add_log_arguments(parser)
    return log_choice(parser.parse_args(words))


def test_logs_are_kept_of_the_runs_that_are_asked_for(tmp_path: Path) -> None:
    assert chosen().of("run-000001") is None
    assert chosen("--logs", str(tmp_path)).of("run-000001") == tmp_path
    some = chosen("--logs", str(tmp_path), "--logs-of", "0007")
    assert [some.of(name) for name in ("run-000001", "run-000007")] == [None, tmp_path]


def test_logs_of_another_time_are_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "0000.mcap").touch()
    with pytest.raises(SystemExit, match="holds run logs already"):
        chosen("--logs", str(tmp_path))


def a_trace() -> tuple[np.ndarray, np.ndarray]:
    """2 m/s along x, and somebody of 0.5 m who stands 20 m ahead of the rear axle, right on the way."""
    t = np.round(np.arange(1, 501) * 0.02, 2)
    rows = np.zeros((len(t), 7))
    rows[:, 0], rows[:, 1], rows[:, 4] = t, 2.0 * t, 2.0
    agents = np.tile((0.0, 1, PEDESTRIAN, 20.0, 0.0, 0.0, 0.5, 0.5), (len(t), 1))
    agents[:, 0] = t
    return rows, agents


def test_the_clearance_is_that_of_outline_and_disc() -> None:
    rows, agents = a_trace()
    times, clear = clearance_over_time(rows, agents, Body())
    expected = 20.0 - 2.0 * times - Body().front_overhang_m - 0.25
    before = expected > 0.0
    assert before.sum() > 50
    assert clear[before] == pytest.approx(expected[before], abs=1e-9)


def test_a_drive_is_drawn_with_way_speed_and_clearance(tmp_path: Path) -> None:
    figure = plot(*a_trace(), Body(), "A drive")
    figure.savefig(tmp_path / "drive.png")
    above, below = figure.axes[:2]
    assert len(above.collections) == 2
    assert below.lines[0].get_ydata()[0] == pytest.approx(7.2)
    assert (tmp_path / "drive.png").stat().st_size > 5000
