"""Second factors as rows, without their secrets, which are derived. Recovery codes are kept as hashes."""

from server.domain.record.second_factors import SecondFactor
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository

_factor = tables.second_factors.c


class SqlSecondFactorRepository(Repository):
    def confirmed(self, operator_id: str) -> SecondFactor | None:
        of_operator = _factor.operator_id == operator_id
        return _from_row(self._one(tables.second_factors, of_operator, _factor.confirmed_at.is_not(None)))

    def begun(self, operator_id: str) -> SecondFactor | None:
        of_operator = _factor.operator_id == operator_id
        return _from_row(self._one(tables.second_factors, of_operator, _factor.confirmed_at.is_(None)))

    def save(self, factor: SecondFactor) -> None:
        self._put(
            tables.second_factors,
            {
                "factor_id": factor.factor_id,
                "operator_id": factor.operator_id,
                "ticket_key_id": factor.ticket_key_id,
                "made_at": factor.made_at,
                "confirmed_at": factor.confirmed_at,
                "last_step": factor.last_step,
                "wrong_codes": factor.wrong_codes,
                "recovery_sha256": to_json(sorted(factor.recovery_sha256)),
            },
        )

    def remove_begun(self, operator_id: str) -> None:
        self._delete(
            tables.second_factors, _factor.operator_id == operator_id, _factor.confirmed_at.is_(None)
        )

    def remove_all(self, operator_id: str) -> None:
        self._delete(tables.second_factors, _factor.operator_id == operator_id)

    def owners(self) -> frozenset[str]:
        statement = self._select(tables.second_factors, _factor.confirmed_at.is_not(None))
        return frozenset(row.operator_id for row in self._many(statement))


def _from_row(row: AnyRow | None) -> SecondFactor | None:
    if row is None:
        return None
    return SecondFactor(
        campus_id=row.campus_id,
        factor_id=row.factor_id,
        operator_id=row.operator_id,
        ticket_key_id=row.ticket_key_id,
        made_at=row.made_at,
        confirmed_at=row.confirmed_at,
        last_step=row.last_step,
        wrong_codes=row.wrong_codes,
        recovery_sha256=frozenset(from_json(row.recovery_sha256, list)),
    )
