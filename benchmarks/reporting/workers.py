"""The worker processes of benchmarks that drive many scenes, and their arguments."""

import argparse
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from campusloop.campaigns.campaign import Campaign, CampaignError
from campusloop.campaigns.choice import open_campaign


def add_worker_arguments(parser: argparse.ArgumentParser, workers: int = 1) -> None:
    """workers: how many there are if nothing is said."""
    parser.add_argument("--workers", type=int, default=workers, help="processes; each takes a core")
    parser.add_argument("--cluster", help="Dask scheduler (tcp://HOST:8786) whose workers drive instead")


@contextmanager
def worker_campaign(arguments: argparse.Namespace, files: Iterable[Path] = ()) -> Iterator[Campaign]:
    """Until the block ends. files: as of `open_campaign`. Raises SystemExit if the campaign fails."""
    # A local worker takes no other core than its own.
    cores = sorted(os.sched_getaffinity(0))[: arguments.workers]
    os.sched_setaffinity(0, cores)
    try:
        with open_campaign(arguments.cluster, len(cores), files=files) as campaign:
            yield campaign
    except CampaignError as error:
        raise SystemExit(f"cannot drive: {error}") from error
