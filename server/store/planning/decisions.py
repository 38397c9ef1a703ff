"""The dispatcher's decisions as rows."""

from datetime import datetime

from server.domain.planning.decisions import (
    Alternative,
    Decision,
    Quote,
    RideDecision,
)
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository

_decision = tables.decisions.c
_ride = tables.ride_decisions.c


class SqlDecisionRepository(Repository):
    def add(self, decision: Decision) -> None:
        values: dict[str, object] = {
            "decision_id": decision.decision_id,
            "made_at": decision.made_at,
            "kind": decision.kind,
            "problem": decision.problem,
            "given": decision.given,
            "answer": decision.answer,
        }
        self._insert(tables.decisions, values)

    def add_rides(self, decided: list[RideDecision]) -> None:
        self._add_missing(
            tables.ride_decisions,
            [
                {
                    "ride_id": one.ride_id,
                    "decision_id": one.decision_id,
                    "made_at": one.made_at,
                    "rule": one.rule,
                    "best": to_json(one.best),
                    "runner_up": to_json(one.runner_up),
                    "alternatives": to_json(one.alternatives),
                    "vehicles": one.vehicles,
                }
                for one in decided
            ],
        )

    def of_ride(self, ride_id: str) -> tuple[RideDecision, ...]:
        rows = self._many(
            self._select(tables.ride_decisions, _ride.ride_id == ride_id).order_by(
                _ride.made_at, _ride.decision_id
            )
        )
        return tuple(
            RideDecision(
                campus_id=row.campus_id,
                ride_id=row.ride_id,
                decision_id=row.decision_id,
                made_at=row.made_at,
                rule=row.rule,
                best=from_json(row.best, Quote | None),  # type: ignore[arg-type]
                runner_up=from_json(row.runner_up, Quote | None),  # type: ignore[arg-type]
                alternatives=from_json(row.alternatives, tuple[Alternative, ...]),
                vehicles=row.vehicles,
            )
            for row in rows
        )

    def get(self, decision_id: str) -> Decision | None:
        row = self._find(tables.decisions, decision_id=decision_id)
        return None if row is None else _from_row(row)

    def between(self, begins: datetime, ends: datetime) -> tuple[Decision, ...]:
        rows = self._many(
            self._select(tables.decisions, _decision.made_at >= begins, _decision.made_at < ends).order_by(
                _decision.made_at, _decision.decision_id
            )
        )
        return tuple(_from_row(row) for row in rows)

    def forget_before(self, oldest: datetime) -> int:
        gone = self._delete(tables.decisions, _decision.made_at < oldest)
        return gone + self._delete(tables.ride_decisions, _ride.made_at < oldest)


def _from_row(row: AnyRow) -> Decision:
    return Decision(
        campus_id=row.campus_id,
        decision_id=row.decision_id,
        made_at=row.made_at,
        kind=row.kind,
        problem=row.problem,
        given=row.given,
        answer=row.answer,
    )
