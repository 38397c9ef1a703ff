"""Campaigns on a real Dask cluster: a scheduler and two worker processes."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from campusloop.campaigns.campaign import CampaignError, WorkerLost
from campusloop.campaigns.choice import open_campaign
from campusloop.cli import app_of
from tests.campusloop.campaigns.jobs import Deadly, environment_mark, failing, number_of, set_mark

distributed = pytest.importorskip("distributed", reason="Dask is not installed: make cluster")
pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as local:
        yield local.scheduler_address


@pytest.fixture
def cluster(scheduler: str) -> str:
    """With both workers: one that a test before has killed may not be back yet."""
    with distributed.Client(scheduler, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
    return scheduler


def test_a_lost_worker_s_job_is_repeated_and_results_come_in_order(cluster: str, tmp_path: Path) -> None:
    jobs = [Deadly(0, tmp_path), Deadly(1, tmp_path, deaths=1), Deadly(2, tmp_path)]
    with open_campaign(cluster, prepare=set_mark) as campaign:
        assert campaign.size == 2
        assert list(campaign.run(number_of, jobs)) == [0, 1, 2]
        assert list(campaign.run(environment_mark, [None])) == ["prepared"]
    assert len(list(tmp_path.iterdir())) == 1


def test_a_job_that_always_ends_its_worker_ends_the_campaign_with_its_name(
    cluster: str, tmp_path: Path
) -> None:
    with open_campaign(cluster) as campaign, pytest.raises(WorkerLost, match="number=7"):
        list(campaign.run(number_of, [Deadly(7, tmp_path, deaths=99)]))


def test_what_a_job_raises_is_raised_here(cluster: str) -> None:
    with open_campaign(cluster) as campaign, pytest.raises(ValueError, match="job 1 is wrong"):
        list(campaign.run(failing, [0, 1]))


def test_a_study_gives_the_same_figures_on_the_cluster(cluster: str, tmp_path: Path) -> None:
    options = ["--vehicles", "1,2", "--speeds", "2", "--lambda", "0.1", "--laps", "1"]
    rows = []
    for name, more in (("here", []), ("there", ["--cluster", cluster])):
        words = ["infrastructure", "gain", "--out", str(tmp_path / name), *options, *more]
        done = CliRunner().invoke(app_of(("infrastructure",)), words)
        assert done.exit_code == 0, done.output
        rows.append(json.loads((tmp_path / name / "gain.json").read_text())["rows"])
    assert rows[0] == rows[1]


def test_a_scheduler_that_is_not_there_is_named() -> None:
    done = CliRunner().invoke(
        app_of(("replay",)), ["replay", str(Path(__file__)), "--cluster", "tcp://127.0.0.1:9"]
    )
    assert done.exit_code == 2
    assert "no Dask scheduler answers at tcp://127.0.0.1:9" in done.output


def test_workers_with_several_threads_are_refused_with_the_command_that_helps() -> None:
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=None) as local,
        pytest.raises(CampaignError, match="--nthreads 1"),
        open_campaign(local.scheduler_address),
    ):
        pass
