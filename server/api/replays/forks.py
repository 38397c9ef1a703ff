"""Forks of the past: the rides from a moment on, dispatched again with another fleet or policy."""

from dataclasses import asdict
from datetime import datetime
from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Path
from pydantic import BaseModel, ConfigDict, Field

from server.api.formats import NAME_PATTERN, Name
from server.api.problems import problems
from server.api.replays.routes import DAY_S_MAX, moment_at
from server.api.security.access import DRIVER_REFUSALS, Actor, changing, now_ns
from server.api.security.permissions import PREVIEW
from server.api.services import InjectedServices
from server.domain.errors import ForkImpossible, ForksBusy, ForkStopped, ForkUnknown
from server.usecases.planning.day_figures import DayFigures
from server.usecases.planning.forks import ForkResult, fork_input

router = APIRouter(prefix="/replays/forks", tags=["runs"])

ForkId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["fork-6f1d0c1e"])]
PolicyName = Literal["insertion", "improvement", "departure-slack", "departure-slack-improvement"]


class ForkRequest(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {"from_ms": 1_788_249_600_000, "seconds": 7200, "more": 1, "policy": "improvement"}
        },
    )

    from_ms: int = Field(ge=0, le=1 << 43, description="The moment, Unix time.")
    seconds: int = Field(7200, ge=60, le=DAY_S_MAX, description="Rides wanted so long after it.")
    more: int = Field(0, ge=-50, le=50, description="Shuttles more, or less if negative.")
    policy: PolicyName = Field("improvement", description="The present one is `improvement`.")
    fork_id: Name | None = Field(None, description="Chosen by the client; by it the fork can be stopped.")


class ForkFigures(BaseModel):
    """Counts of rides; times of the served ones in seconds, null without any."""

    shuttles: int
    asked: int
    served: int
    cancelled: int
    refused: int
    wait_median_s: float | None
    wait_p95_s: float | None
    ride_mean_s: float | None
    driving_h: float
    promises_kept: int


class ForkedRideView(BaseModel):
    """A ride as it was and in both forks; waits from the requested time to boarding, null without."""

    ride_id: str
    ride_code: str
    from_stop: str
    to_stop: str
    party: int
    requested_at: datetime
    then_state: str
    then_wait_s: float | None
    present_end: Literal["served", "refused", "cancelled"]
    present_wait_s: float | None
    changed_end: Literal["served", "refused", "cancelled"]
    changed_wait_s: float | None


class ForkView(BaseModel):
    """present: the fleet and the policy of then, dispatched again; changed: with the change.

    Both happen as planned: compare them with each other, and `then` only with care. placed: so many shuttles
    begin where they were; the others at resting places.
    """

    placed: int
    present: ForkFigures
    changed: ForkFigures
    rides: list[ForkedRideView]
    computing_s: float = Field(description="What it took one processor of the server.")


@router.post(
    "",
    operation_id="fork_the_past",
    responses=problems(ForkImpossible, ForkStopped, ForksBusy, *DRIVER_REFUSALS),
)
async def fork_the_past(
    request: ForkRequest,
    services: InjectedServices,
    actor: Annotated[Actor, Depends(changing(PREVIEW))],
) -> ForkView:
    """Dispatch the rides from a moment on again, and compare. Nothing changes. It takes seconds."""
    services.limits.commands.take(actor.account, now_ns(services))
    at, until = moment_at(request.from_ms), moment_at(request.from_ms + 1000 * request.seconds)
    fork = await services.transactions.read(
        lambda uow: fork_input(uow, at, until, request.more, request.policy)
    )
    return _view(await services.forks.run(fork, request.fork_id or ""))


@router.delete(
    "/{fork_id}",
    operation_id="stop_fork",
    status_code=204,
    responses=problems(ForkUnknown, *DRIVER_REFUSALS),
)
async def stop_fork(
    fork_id: ForkId, services: InjectedServices, actor: Annotated[Actor, Depends(changing(PREVIEW))]
) -> None:
    """Give up a comparison that this server computes. The request that asked for it gets `fork_stopped`."""
    services.limits.commands.take(actor.account, now_ns(services))
    services.forks.stop(fork_id)


def _view(result: ForkResult) -> ForkView:
    return ForkView(
        placed=result.placed,
        present=_figures(result.present, result.present_shuttles),
        changed=_figures(result.changed, result.changed_shuttles),
        rides=[ForkedRideView(**asdict(ride)) for ride in result.rides],
        computing_s=round(result.computing_s, 2),
    )


def _figures(figures: DayFigures, shuttles: int) -> ForkFigures:
    return ForkFigures(
        shuttles=shuttles,
        asked=figures.asked,
        served=figures.served,
        cancelled=figures.cancelled,
        refused=figures.refused,
        wait_median_s=figures.wait_median_s,
        wait_p95_s=figures.wait_p95_s,
        ride_mean_s=figures.ride_mean_s,
        driving_h=figures.driving_h,
        promises_kept=figures.promises_kept,
    )
