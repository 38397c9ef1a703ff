"""Operators, sessions, keys, codes and tokens as rows. Secrets are kept as hashes only."""

from datetime import datetime

from server.domain.record.identity import (
    DeveloperToken,
    EnrolmentCode,
    Operator,
    OperatorSession,
    VehicleKey,
)
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository

_operator = tables.operators.c
_session = tables.operator_sessions.c
_key = tables.vehicle_keys.c
_code = tables.enrolment_codes.c
_token = tables.developer_tokens.c
_ticket_key = tables.ticket_keys.c


class SqlIdentityRepository(Repository):
    def operator(self, operator_id: str) -> Operator | None:
        return _operator_from(self._find(tables.operators, operator_id=operator_id))

    def operator_by_name(self, name: str) -> Operator | None:
        return _operator_from(self._find(tables.operators, name=name))

    def save_operator(self, operator: Operator) -> None:
        self._put(
            tables.operators,
            {
                "operator_id": operator.operator_id,
                "name": operator.name,
                "password_hash": operator.password_hash,
                "created_at": operator.created_at,
                "roles": to_json(sorted(operator.roles)),
                "disabled_at": operator.disabled_at,
                "initial_until": operator.initial_until,
            },
        )

    def operators(self) -> tuple[Operator, ...]:
        rows = self._many(self._select(tables.operators).order_by(_operator.name))
        return tuple(operator for row in rows if (operator := _operator_from(row)) is not None)

    def operator_session(self, token_sha256: str) -> OperatorSession | None:
        row = self._find(tables.operator_sessions, token_sha256=token_sha256)
        if row is None:
            return None
        return OperatorSession(
            row.campus_id, row.token_sha256, row.operator_id, row.opened_at, row.expires_at, row.checked_at
        )

    def add_operator_session(self, session: OperatorSession) -> None:
        self._insert(
            tables.operator_sessions,
            {
                "token_sha256": session.token_sha256,
                "operator_id": session.operator_id,
                "opened_at": session.opened_at,
                "expires_at": session.expires_at,
                "checked_at": session.checked_at,
            },
        )

    def mark_checked(self, token_sha256: str, at: datetime) -> None:
        self._change(tables.operator_sessions, {"checked_at": at}, token_sha256=token_sha256)

    def remove_operator_session(self, token_sha256: str) -> None:
        self._delete(tables.operator_sessions, _session.token_sha256 == token_sha256)

    def remove_sessions_of(self, operator_id: str) -> None:
        self._delete(tables.operator_sessions, _session.operator_id == operator_id)

    def remove_other_sessions(self, operator_id: str, token_sha256: str) -> None:
        self._delete(
            tables.operator_sessions,
            _session.operator_id == operator_id,
            _session.token_sha256 != token_sha256,
        )

    def forget_sessions_before(self, moment: datetime) -> int:
        """How many expired sessions were dropped."""
        return self._delete(tables.operator_sessions, _session.expires_at < moment)

    def vehicle_key(self, vehicle_id: str) -> VehicleKey | None:
        row = self._find(tables.vehicle_keys, vehicle_id=vehicle_id)
        if row is None:
            return None
        return VehicleKey(row.campus_id, row.vehicle_id, row.public_key, row.enrolled_at, row.revoked_at)

    def save_vehicle_key(self, key: VehicleKey) -> None:
        self._put(
            tables.vehicle_keys,
            {
                "vehicle_id": key.vehicle_id,
                "public_key": key.public_key,
                "enrolled_at": key.enrolled_at,
                "revoked_at": key.revoked_at,
            },
        )

    def enrolment_code(self, code_sha256: str) -> EnrolmentCode | None:
        row = self._find(tables.enrolment_codes, code_sha256=code_sha256)
        if row is None:
            return None
        return EnrolmentCode(
            row.campus_id, row.code_sha256, row.vehicle_id, row.made_by, row.expires_at, row.used_at
        )

    def save_enrolment_code(self, code: EnrolmentCode) -> None:
        self._put(
            tables.enrolment_codes,
            {
                "code_sha256": code.code_sha256,
                "vehicle_id": code.vehicle_id,
                "made_by": code.made_by,
                "expires_at": code.expires_at,
                "used_at": code.used_at,
            },
        )

    def developer_token(self, token_sha256: str) -> DeveloperToken | None:
        return _token_from(self._find(tables.developer_tokens, token_sha256=token_sha256))

    def developer_token_by_id(self, token_id: str) -> DeveloperToken | None:
        return _token_from(self._find(tables.developer_tokens, token_id=token_id))

    def developer_tokens(self) -> tuple[DeveloperToken, ...]:
        rows = self._many(
            self._select(tables.developer_tokens).order_by(_token.created_at.desc(), _token.token_id)
        )
        return tuple(token for row in rows if (token := _token_from(row)) is not None)

    def save_developer_token(self, token: DeveloperToken) -> None:
        self._put(
            tables.developer_tokens,
            {
                "token_id": token.token_id,
                "name": token.name,
                "token_sha256": token.token_sha256,
                "scopes": to_json(sorted(token.scopes)),
                "made_by": token.made_by,
                "created_at": token.created_at,
                "expires_at": token.expires_at,
                "revoked_at": token.revoked_at,
            },
        )

    def ticket_key_ids(self) -> tuple[str, ...]:
        statement = self._select(tables.ticket_keys).order_by(_ticket_key.first_used_at, _ticket_key.key_id)
        return tuple(row.key_id for row in self._many(statement))

    def add_ticket_key(self, key_id: str, at: datetime) -> None:
        self._insert(tables.ticket_keys, {"key_id": key_id, "first_used_at": at})


def _operator_from(row: AnyRow | None) -> Operator | None:
    if row is None:
        return None
    return Operator(
        campus_id=row.campus_id,
        operator_id=row.operator_id,
        name=row.name,
        password_hash=row.password_hash,
        created_at=row.created_at,
        roles=frozenset(from_json(row.roles, list)),
        disabled_at=row.disabled_at,
        initial_until=row.initial_until,
    )


def _token_from(row: AnyRow | None) -> DeveloperToken | None:
    if row is None:
        return None
    return DeveloperToken(
        campus_id=row.campus_id,
        token_id=row.token_id,
        name=row.name,
        token_sha256=row.token_sha256,
        scopes=frozenset(from_json(row.scopes, list)),
        made_by=row.made_by,
        created_at=row.created_at,
        expires_at=row.expires_at,
        revoked_at=row.revoked_at,
    )
