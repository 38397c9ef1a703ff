"""Jobs on processes of this machine."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Any

from campusloop.campaigns.campaign import Campaign, Handle, WorkerLost
from server.supervision.parent_end import end_with_parent

# A job during which this many workers in a row were lost will end the next one too.
LOST_MAX = 3


class LocalCampaign(Campaign):
    """A pool of processes; one that is killed is replaced, and the jobs without a result are repeated."""

    def __init__(self, size: int, prepare: Callable[[], None] | None) -> None:
        """prepare: called once in each process, before its first job."""
        self.size = size
        self._prepare = prepare
        self._pool = self._new_pool()
        self._blamed: object = None
        self._times_lost = 0

    def close(self) -> None:
        """End the processes; jobs that have begun are finished."""
        self._pool.shutdown(cancel_futures=True)

    @property
    def _lost(self) -> tuple[type[BaseException], ...]:
        return (BrokenProcessPool,)

    def _submit(self, function: Callable[[Any], Any], job: Any) -> Handle:
        try:
            return self._pool.submit(function, job)
        except BrokenProcessPool:
            # It broke between two results; the jobs that it had are submitted again when they are asked for.
            self._pool = self._new_pool()
            return self._pool.submit(function, job)

    def _recover(self, job: object, error: BaseException) -> None:
        # It is not known which of the running jobs ended the pool. The first one is repeated and counted.
        self._times_lost = self._times_lost + 1 if job is self._blamed else 1
        self._blamed = job
        if self._times_lost >= LOST_MAX:
            raise WorkerLost(
                f"a worker process has ended {LOST_MAX} times during {job!r} or a job beside it; "
                "see the system's log (out of memory?), or take fewer workers"
            ) from error
        self._pool.shutdown(cancel_futures=True)
        self._pool = self._new_pool()

    def _new_pool(self) -> ProcessPoolExecutor:
        # A fork would copy the threads' locks of the parent.
        return ProcessPoolExecutor(
            self.size, mp_context=get_context("spawn"), initializer=_begin, initargs=(self._prepare,)
        )


def _begin(prepare: Callable[[], None] | None) -> None:
    end_with_parent()
    if prepare is not None:
        prepare()
