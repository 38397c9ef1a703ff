"""Campaigns on processes of this machine."""

import errno
from itertools import count, islice
from pathlib import Path
from unittest.mock import patch

import pytest

from campusloop.campaigns.campaign import Campaign, WorkerLost
from campusloop.campaigns.choice import open_campaign
from campusloop.campaigns.local import LocalCampaign
from tests.campusloop.campaigns.jobs import Deadly, environment_mark, failing, number_of, set_mark, squared


class Inline(Campaign):
    """Runs each job when its result is asked for, and counts the jobs that were taken."""

    size = 1

    def __init__(self) -> None:
        self.taken: list[object] = []
        self.cancelled: list[object] = []

    def close(self) -> None: ...

    @property
    def _lost(self) -> tuple[type[BaseException], ...]:
        return (ConnectionError,)

    def _submit(self, function, job):  # type: ignore[no-untyped-def]
        self.taken.append(job)
        return InlineHandle(self, function, job)

    def _recover(self, job: object, error: BaseException) -> None: ...


class InlineHandle:
    def __init__(self, campaign: Inline, function, job) -> None:  # type: ignore[no-untyped-def]
        self._campaign, self._function, self._job = campaign, function, job

    def result(self) -> object:
        return self._function(self._job)

    def cancel(self) -> None:
        self._campaign.cancelled.append(self._job)


def test_an_endless_row_of_jobs_is_taken_only_so_far_ahead() -> None:
    campaign = Inline()
    results = campaign.run(squared, count(), ahead=3)
    assert list(islice(results, 2)) == [0, 1]
    results.close()
    assert campaign.taken == [0, 1, 2, 3]
    assert campaign.cancelled == [2, 3]


def test_a_failing_job_is_raised_and_the_others_are_cancelled() -> None:
    campaign = Inline()
    with pytest.raises(ValueError, match="job 1 is wrong"):
        list(campaign.run(failing, range(4)))
    assert campaign.cancelled == [1, 2, 3]


def test_no_jobs_give_no_results() -> None:
    assert list(Inline().run(squared, [])) == []


def test_results_come_in_order_from_prepared_processes_and_a_killed_one_is_replaced(tmp_path: Path) -> None:
    jobs = [Deadly(0, tmp_path), Deadly(1, tmp_path, deaths=1), Deadly(2, tmp_path)]
    with open_campaign(workers=2, prepare=set_mark) as campaign:
        assert list(campaign.run(environment_mark, [None])) == ["prepared"]
        assert list(campaign.run(number_of, jobs)) == [0, 1, 2]
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    "error", [ValueError("bad value(s) in fds_to_keep"), OSError(errno.EBADF, "bad file")]
)
def test_a_pool_whose_pipes_are_being_closed_is_replaced(tmp_path: Path, error: Exception) -> None:
    """A worker was killed, and the next job is submitted while the pool notices."""
    with open_campaign(workers=2, prepare=None) as campaign:
        assert isinstance(campaign, LocalCampaign)
        with patch.object(campaign._pool, "submit", side_effect=error):
            assert list(campaign.run(number_of, [Deadly(k, tmp_path) for k in range(3)])) == [0, 1, 2]


def test_a_job_that_always_ends_its_process_ends_the_campaign_with_its_name(tmp_path: Path) -> None:
    with open_campaign(workers=1) as campaign, pytest.raises(WorkerLost, match="number=7"):
        list(campaign.run(number_of, [Deadly(7, tmp_path, deaths=99)]))
    assert len(list(tmp_path.iterdir())) == 3
