"""How much longer than planned driving takes, hour by hour, as the fleet has measured it."""

from datetime import datetime

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field

from server.api.problems import problems
from server.api.security.access import READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.domain.errors import CampusUnknown
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import travel_time_factors

router = APIRouter(tags=["service"])


class HourFactor(BaseModel):
    hour: int = Field(description="Campus local: 8 is from 08:00 to 09:00.")
    factor: float = Field(description="Planned driving is multiplied by this; 1 as in the map's times.")
    legs: int = Field(description="How many drives from stop to stop it rests on.")


class TravelTimes(BaseModel):
    """Factors between 0.5 and 3, drawn towards 1 where few drives have been measured."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "timezone": "Asia/Shanghai",
                "learned_at": "2026-09-01T08:00:00Z",
                "hours": [{"hour": 8, "factor": 1.34, "legs": 112}],
            }
        }
    )

    timezone: str
    learned_at: datetime | None = Field(description="Null while nothing has been learnt.")
    hours: list[HourFactor]


@router.get(
    "/travel-times", operation_id="get_travel_times", responses=problems(CampusUnknown, *READER_REFUSALS)
)
async def get_travel_times(services: InjectedServices, _: Reader) -> TravelTimes:
    """What plans and promises multiply driving by, at each hour of the day."""

    def work(uow: UnitOfWork) -> TravelTimes:
        found = travel_time_factors.present(uow)
        return TravelTimes(
            timezone=uow.network().road_map.timezone,
            learned_at=found.learned_at,
            hours=[
                HourFactor(hour=hour, factor=round(factor, 4), legs=legs)
                for hour, (factor, legs) in enumerate(zip(found.factors, found.legs, strict=True))
            ],
        )

    return await services.transactions.read(work)
