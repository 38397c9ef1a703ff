"""Jobs on processes of this machine."""

import errno
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any

from campusloop.campaigns.campaign import Campaign, Handle, WorkerLost
from server.supervision.parent_end import end_with_parent

# A job during which this many workers in a row were lost will end the next one too.
LOST_MAX = 3


class _Processes(SpawnContext):
    """Spawns, and knows what it has spawned. A fork would copy the threads' locks of the parent."""

    def __init__(self) -> None:
        super().__init__()
        self._spawned: list[SpawnProcess] = []

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802
        process = SpawnProcess(*args, **kwargs)
        self._spawned.append(process)
        return process

    def kill_all(self) -> None:
        for process in self._spawned:
            if process.pid is not None:
                process.kill()


class LocalCampaign(Campaign):
    """A pool of processes; one that is killed is replaced, and the jobs without a result are repeated."""

    def __init__(self, size: int, prepare: Callable[[], None] | None) -> None:
        """prepare: called once in each process, before its first job."""
        self.size = size
        self._prepare = prepare
        self._processes = _Processes()
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
        except (BrokenProcessPool, ValueError, OSError) as error:
            if isinstance(error, OSError) and error.errno != errno.EBADF:
                raise
            # It broke between two results; the jobs that it had are submitted again when they are asked for.
            # While it breaks, it closes its pipes, and a process that is spawned meanwhile cannot have them.
            self._replace_pool()
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
        self._replace_pool()

    def _replace_pool(self) -> None:
        # A broken pool ends its processes, but not one that a submission has spawned meanwhile: it would wait
        # for that one for ever.
        self._processes.kill_all()
        self._pool.shutdown(cancel_futures=True)
        self._processes = _Processes()
        self._pool = self._new_pool()

    def _new_pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(
            self.size, mp_context=self._processes, initializer=_begin, initargs=(self._prepare,)
        )


def _begin(prepare: Callable[[], None] | None) -> None:
    end_with_parent()
    if prepare is not None:
        prepare()
