"""What a campaign is: jobs in, results out, in the jobs' order."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar, cast

Job = TypeVar("Job")
Result = TypeVar("Result")


class CampaignError(Exception):
    """The campaign cannot start or go on; the message says what to do."""


class WorkerLost(CampaignError):
    """One job has ended its worker several times."""


class Handle(Protocol):
    """A submitted job."""

    def result(self) -> Any: ...

    def cancel(self) -> Any: ...


@dataclass(slots=True)
class _Submitted:
    job: Any
    handle: Handle


class Campaign(ABC):
    """Worker processes and the jobs that they were given.

    size   the number of jobs that run at the same time
    """

    size: int

    def run(
        self, function: Callable[[Job], Result], jobs: Iterable[Job], ahead: int | None = None
    ) -> Generator[Result]:
        """The results in the order of the jobs; a job whose worker was lost is repeated on another.

        function and jobs are pickled. An exception of the function is raised here, and the other jobs end.

        ahead   at most so many jobs are taken before the first of them has its result; None: all jobs

        Raises WorkerLost and CampaignError.
        """
        coming = iter(jobs)
        submitted: deque[_Submitted] = deque()
        try:
            while True:
                for job in coming:
                    submitted.append(_Submitted(job, self._submit(function, job)))
                    if ahead is not None and len(submitted) >= ahead:
                        break
                if not submitted:
                    return
                first = submitted[0]
                try:
                    result = first.handle.result()
                except self._lost as error:
                    self._recover(first.job, error)
                    for one in submitted:
                        one.handle = self._submit(function, one.job)
                    continue
                submitted.popleft()
                yield cast("Result", result)
        finally:
            for one in submitted:
                one.handle.cancel()

    @abstractmethod
    def close(self) -> None:
        """Give the workers back."""

    @property
    @abstractmethod
    def _lost(self) -> tuple[type[BaseException], ...]:
        """What `Handle.result` raises when the worker is gone and the jobs have to be submitted again."""

    @abstractmethod
    def _submit(self, function: Callable[[Any], Any], job: Any) -> Handle: ...

    @abstractmethod
    def _recover(self, job: object, error: BaseException) -> None:
        """Make the workers ready again; `job` is the first without a result. Raises WorkerLost."""
