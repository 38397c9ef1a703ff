"""Driven legs and the travel time factors learnt from them, as rows."""

from datetime import datetime

from server.domain.planning.travel_time_factors import DrivenLeg, TravelTimeFactors
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import Repository

_leg = tables.driven_legs.c


class SqlTravelTimeFactorRepository(Repository):
    def begin_leg(self, vehicle_id: str, from_stop: str, left_at: datetime) -> None:
        self._put(tables.open_legs, {"vehicle_id": vehicle_id, "from_stop": from_stop, "left_at": left_at})

    def end_leg(self, vehicle_id: str) -> tuple[str, datetime] | None:
        row = self._find(tables.open_legs, vehicle_id=vehicle_id)
        if row is None:
            return None
        self._delete(tables.open_legs, tables.open_legs.c.vehicle_id == vehicle_id)
        return row.from_stop, row.left_at

    def add(self, leg: DrivenLeg) -> None:
        self._put(
            tables.driven_legs,
            {
                "vehicle_id": leg.vehicle_id,
                "left_at": leg.left_at,
                "from_stop": leg.from_stop,
                "to_stop": leg.to_stop,
                "hour": leg.hour,
                "planned_s": leg.planned_s,
                "driven_s": leg.driven_s,
            },
        )

    def legs(self) -> tuple[DrivenLeg, ...]:
        rows = self._many(self._select(tables.driven_legs).order_by(_leg.left_at, _leg.vehicle_id))
        return tuple(
            DrivenLeg(
                row.campus_id,
                row.vehicle_id,
                row.left_at,
                row.from_stop,
                row.to_stop,
                row.hour,
                row.planned_s,
                row.driven_s,
            )
            for row in rows
        )

    def forget_before(self, moment: datetime) -> int:
        return self._delete(tables.driven_legs, _leg.left_at < moment)

    def present(self) -> TravelTimeFactors | None:
        row = self._find(tables.travel_time_factors)
        if row is None:
            return None
        return TravelTimeFactors(
            from_json(row.factors, tuple[float, ...]), from_json(row.legs, tuple[int, ...]), row.learned_at
        )

    def save(self, factors: TravelTimeFactors) -> None:
        self._put(
            tables.travel_time_factors,
            {
                "factors": to_json(factors.factors),
                "legs": to_json(factors.legs),
                "learned_at": factors.learned_at,
            },
        )
