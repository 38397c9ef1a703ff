"""Independent steps of one cycle: a step that fails does not keep the others from their work."""

from collections.abc import Awaitable, Callable, Iterable, Sequence
from functools import partial

from server.domain.errors import DomainError, LeaseLost, StoreFailure
from server.usecases.ports.unit_of_work import UnitOfWork

Step = Callable[[UnitOfWork], object]


async def run_steps(steps: Iterable[Callable[[], Awaitable[object]]]) -> None:
    """Run every step in order, also after one has failed. A step may consist of steps.

    Raises ExceptionGroup with all defects; the first refusal (DomainError) if there were only refusals. A
    StoreFailure or a lost lease is raised at once: the other steps would fail in the same way.
    """
    refusals: list[DomainError] = []
    defects: list[Exception] = []
    for step in steps:
        try:
            await step()
        except (StoreFailure, LeaseLost):
            raise
        except DomainError as error:
            refusals.append(error)
        except ExceptionGroup as group:
            defects += group.exceptions
        except Exception as error:
            defects.append(error)
    if defects:
        raise ExceptionGroup("steps of one cycle failed", defects)
    if refusals:
        raise refusals[0]


async def run_together(run: Callable[[Step], Awaitable[object]], works: Sequence[Step]) -> None:
    """Run all works, in order, in one transaction. If one fails, each is run in a transaction of its own.

    run  runs a use case in a transaction that a failure rolls back
    Raises what `run_steps` raises. One transaction costs less than many, most of which change nothing.
    """

    def every(uow: UnitOfWork) -> None:
        for work in works:
            work(uow)

    try:
        await run(every)
    except (StoreFailure, LeaseLost):
        raise
    except Exception:
        # Not lost: the work that fails fails again, alone.
        await run_steps(partial(run, work) for work in works)
