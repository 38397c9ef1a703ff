"""`campusloop dispatch bound` from the outside."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.studies.bound.progress import Progress
from campusloop.studies.bound.warm import warm_kernels as warm_bound
from campusloop.studies.dispatch.bound_run import run_bound
from campusloop.studies.instances.load import load_instance
from server.dispatch.engine.warm import warm_kernels as warm_engine
from tests.campusloop.studies.bound.small_instances import a_ring

RUN = CliRunner()


def cordeau_text(requests: int, vehicles: int, seed: int) -> str:
    """As Cordeau (2006, section 6) drew his: half of the requests with a window of 15 min at the drop-off,
    half at the pickup, 3 min of service, 3 places, rides of 30 min at most.
    """
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-10.0, 10.0, (2 * requests, 2)).round(3)
    early, late = np.zeros(2 * requests, np.int64), np.full(2 * requests, 1440)
    for request in range(requests):
        node = request + requests if request < requests // 2 else request
        early[node] = rng.integers(60, 60 + 15 * requests)
        late[node] = early[node] + 15
    rows = [f"{vehicles} {2 * requests} 480 3 30", "0 0 0 0 0 0 1440"]
    for k, (x, y) in enumerate(xy):
        rows.append(f"{k + 1} {x} {y} 3 {1 if k < requests else -1} {early[k]} {late[k]}")
    return "\n".join(rows) + "\n"


@pytest.fixture(scope="module", autouse=True)
def warmed() -> None:
    """No test's time has the compiler in it."""
    warm_engine()
    warm_bound()


@pytest.fixture
def twelve(tmp_path: Path) -> Path:
    path = tmp_path / "twelve.txt"
    path.write_text(cordeau_text(12, 3, seed=1))
    return path


def invoked(*words: str) -> tuple[int, str]:
    done = RUN.invoke(app_of(["dispatch"]), ["dispatch", "bound", *words])
    return done.exit_code, " ".join(done.output.split())


def test_bound_solution_and_gap_are_printed_and_written(twelve: Path, tmp_path: Path) -> None:
    report_path = tmp_path / "report.json"
    code, output = invoked(str(twelve), "--seconds", "120", "--json", str(report_path))
    assert code == 0, output
    report = json.loads(report_path.read_text())
    assert report["closed"]
    assert report["bound"] <= report["solution"] + 1e-6
    assert report["solution"] - report["bound"] < 0.005
    assert sorted(node for route in report["routes"] for node in route) == list(range(1, 25))
    for word in ("bound", "best solution", "gap", "nothing: the best solution is optimal"):
        assert word in output


def test_without_time_the_bound_is_weak_but_valid_and_says_why(twelve: Path) -> None:
    instance = load_instance(twelve)
    whole, cut_short = run_bound(instance, 120.0), run_bound(instance, 0.0)
    assert cut_short.stopped
    assert cut_short.limited_by.startswith("time")
    assert cut_short.gap_pct is None
    assert 0.0 <= cut_short.proven.bound <= whole.proven.bound
    assert whole.limited_by == ""
    assert not whole.stopped


def test_a_search_that_serves_nobody_leaves_the_plan_to_the_proof(twelve: Path) -> None:
    instance = load_instance(twelve)
    seen: list[Progress] = []
    run = run_bound(instance, 1e-9, watch=seen.append)
    assert run.best.routes == ()
    assert len(seen) == 1


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (None, "No such file"),
        ("", "first line has 0 numbers"),
        ("2 4 480 3 30\n0 0 0 0 0 0 1440\n1 1 1 3 1 0\n", "line 3: 6 columns instead of 7"),
        ("nonsense\n", "begin with five"),
        (cordeau_text(3, 1, 1).replace("480 3 30", "480 3 1"), "no route can serve the request of node"),
        (cordeau_text(3, 1, 1).replace(" 1440", " 1e9").replace("480 3 30", "1e9 3 1e9"), ""),
    ],
)
def test_bad_input_ends_with_its_reason(text: str | None, complaint: str, tmp_path: Path) -> None:
    path = tmp_path / "broken.txt"
    if text is not None:
        path.write_text(text)
    code, output = invoked(str(path), "--seconds", "1")
    if not complaint:  # endless windows are no reason to fail
        assert code == 0, output
        return
    assert code == 2
    assert complaint in output
    assert "Traceback" not in output


def test_a_folder_is_all_instances_in_it(tmp_path: Path) -> None:
    folder, report = tmp_path / "instances", tmp_path / "report.json"
    folder.mkdir()
    for name, vehicles in (("a", 3), ("b", 3), ("few", 1)):
        (folder / f"{name}.txt").write_text(cordeau_text(4, vehicles, 1))
    code, output = invoked(str(folder), "--seconds", "60", "--workers", "2", "--json", str(report))
    assert code == 0, output
    first, second, few = json.loads(report.read_text())["instances"]
    assert first["bound"] == second["bound"] > 0.0
    assert first["closed"]
    assert "cannot serve all requests" in few["limited_by"], "one without a solution does not end the others"
    code, output = invoked(str(folder), "--upper", "10")
    assert code == 2
    assert "several instances" in output


def test_an_empty_folder_and_a_report_that_cannot_be_written_are_refused(
    twelve: Path, tmp_path: Path
) -> None:
    (tmp_path / "empty").mkdir()
    code, output = invoked(str(tmp_path / "empty"))
    assert code == 2
    assert "no instances there" in output
    code, output = invoked(str(twelve), "--seconds", "1", "--json", str(tmp_path / "none" / "report.json"))
    assert code == 2
    assert "No such file" in output


def test_no_more_is_proven_than_the_cost_that_was_given() -> None:
    ring = a_ring(10)  # its relaxation is 173, its optimum 190
    capped = run_bound(ring, 20.0, upper=180.0)
    assert 180.0 - 1e-4 <= capped.proven.bound <= 190.0
    assert not capped.closed
    assert capped.limited_by.startswith("the cost that was given")
