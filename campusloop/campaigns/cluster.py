"""Jobs on the workers of a Dask cluster (the extra `cluster`)."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from distributed import Client, Future, KilledWorker
from distributed.client import FutureCancelledError
from distributed.comm.core import CommClosedError

from campusloop.campaigns.campaign import Campaign, CampaignError, Handle, WorkerLost
from campusloop.campaigns.installation import CheckedCall, WorkerDiffers, file_digests, installation

CONNECT_TIMEOUT_S = 5.0


class ClusterCampaign(Campaign):
    """The workers that a Dask scheduler has. Dask itself repeats the jobs of workers that are lost."""

    def __init__(self, address: str, prepare: Callable[[], None] | None, files: Iterable[Path]) -> None:
        """Connect to the scheduler at `address`.

        prepare  called once in each worker, before its first job
        files    files and folders that the jobs name by their paths; the workers must have the same there

        Raises CampaignError: there is no scheduler, it has no worker, or a worker has more than one thread.
        """
        self._address = address
        self._prepare = prepare
        self._files = file_digests(files)
        try:
            self._client = Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except (OSError, ValueError, CommClosedError) as error:
            raise CampaignError(f"no Dask scheduler answers at {address} ({error})") from error
        try:
            self.size = self._workers()
        except CampaignError:
            self._client.close()
            raise

    def close(self) -> None:
        """Leave the cluster; it goes on without this campaign's jobs."""
        self._client.close()

    @property
    def _lost(self) -> tuple[type[BaseException], ...]:
        return (CommClosedError,)

    def _submit(self, function: Callable[[Any], Any], job: Any) -> Handle:
        call = CheckedCall(function, installation(), self._files, self._prepare)
        # Two equal jobs are two jobs.
        return _ClusterHandle(self._client.submit(call, job, pure=False), job, self._address)

    def _recover(self, job: object, error: BaseException) -> None:
        raise CampaignError(f"the connection to the Dask scheduler at {self._address} is lost") from error

    def _workers(self) -> int:
        workers = self._client.scheduler_info(n_workers=-1)["workers"]
        if not workers:
            raise CampaignError(
                f"the Dask scheduler at {self._address} has no worker; "
                f"start some: dask worker {self._address} --nthreads 1 --nworkers auto"
            )
        threaded = [str(worker["host"]) for worker in workers.values() if worker["nthreads"] != 1]
        if threaded:
            # A drive owns its process: its event loop, its logging and its cores.
            raise CampaignError(
                f"workers with several threads on {', '.join(sorted(set(threaded)))}; "
                f"start them with: dask worker {self._address} --nthreads 1 --nworkers auto"
            )
        return len(workers)


class _ClusterHandle:
    def __init__(self, future: Future, job: object, address: str) -> None:
        self._future = future
        self._job = job
        self._address = address

    def result(self) -> Any:
        try:
            return self._future.result()
        except KilledWorker as error:
            raise WorkerLost(
                f"every worker that ran {self._job!r} has ended; see the workers' logs (out of memory?)"
            ) from error
        except WorkerDiffers as error:
            raise CampaignError(str(error)) from error
        except FutureCancelledError as error:
            raise CampaignError(f"the Dask scheduler at {self._address} has dropped the jobs") from error

    def cancel(self) -> None:
        self._future.cancel()
