"""Which workers a campaign gets: those of a cluster that was named, or processes of this machine."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from campusloop.campaigns.campaign import Campaign, CampaignError
from campusloop.campaigns.local import LocalCampaign


@contextmanager
def open_campaign(
    cluster: str | None = None,
    workers: int = 0,
    prepare: Callable[[], None] | None = None,
    files: Iterable[Path] = (),
) -> Iterator[Campaign]:
    """Worker processes until the block ends.

    cluster  address of a Dask scheduler (tcp://HOST:8786); None: processes of this machine
    workers  their number on this machine; 0: one for each core
    prepare  called once in each worker, before its first job
    files    files and folders that the jobs name by their paths; a cluster's workers must have the same there

    Raises CampaignError and OSError.
    """
    campaign = _open(cluster, workers, prepare, files)
    try:
        yield campaign
    finally:
        campaign.close()


def _open(
    cluster: str | None, workers: int, prepare: Callable[[], None] | None, files: Iterable[Path]
) -> Campaign:
    if cluster is None:
        return LocalCampaign(workers or len(os.sched_getaffinity(0)), prepare)
    try:
        from campusloop.campaigns.cluster import ClusterCampaign
    except ModuleNotFoundError as error:
        raise CampaignError(
            f"--cluster needs Dask, and {error.name} is not installed: pip install 'campusloop[cluster]'"
        ) from error
    return ClusterCampaign(cluster, prepare, files)
