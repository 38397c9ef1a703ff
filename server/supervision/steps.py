"""Independent steps of one cycle: a step that fails does not keep the others from their work."""

from collections.abc import Awaitable, Callable, Iterable

from server.domain.errors import DomainError, StoreFailure


async def run_steps(steps: Iterable[Callable[[], Awaitable[object]]]) -> None:
    """Run every step in order, also after one has failed.

    Raises ExceptionGroup with all defects; the first refusal (DomainError) if there were only refusals. A
    StoreFailure is raised at once: the other steps would fail in the same way, each after a long wait.
    """
    refusals: list[DomainError] = []
    defects: list[Exception] = []
    for step in steps:
        try:
            await step()
        except StoreFailure:
            raise
        except DomainError as error:
            refusals.append(error)
        except Exception as error:
            defects.append(error)
    if defects:
        raise ExceptionGroup("steps of one cycle failed", defects)
    if refusals:
        raise refusals[0]
