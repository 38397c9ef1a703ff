"""Stored answers to commands, by account and idempotency key."""

from collections.abc import Sequence
from datetime import datetime

from server.domain.record.answers import KeyedRequest, StoredAnswer
from server.store import tables
from server.store.repository import Repository, dialect_insert

_answer = tables.command_answers.c


class SqlAnswerRepository(Repository):
    def claim(self, request: KeyedRequest, now: datetime) -> StoredAnswer | None:
        """The insert waits for a transaction that uses the same key, and then finds its row."""
        statement = dialect_insert(self._connection.dialect.name, tables.command_answers)
        row = {
            "campus_id": self._campus_id,
            "account": request.account,
            "key_sha256": request.key_sha256,
            "request_sha256": request.request_sha256,
            "sealed": b"",
            "made_at": now,
        }
        self._require_lock()
        claiming = statement.values(**row).on_conflict_do_nothing().returning(_answer.key_sha256)
        if self._connection.execute(claiming).first() is not None:
            return None
        found = self._find(tables.command_answers, account=request.account, key_sha256=request.key_sha256)
        assert found is not None
        known = KeyedRequest(found.account, found.key_sha256, found.request_sha256)
        return StoredAnswer(found.campus_id, known, found.sealed, found.made_at)

    def complete(self, request: KeyedRequest, sealed: bytes) -> None:
        self._change(
            tables.command_answers,
            {"sealed": sealed},
            account=request.account,
            key_sha256=request.key_sha256,
        )

    def forget_accounts(self, accounts: Sequence[str]) -> int:
        return self._delete(tables.command_answers, _answer.account.in_(accounts))

    def forget_before(self, moment: datetime) -> int:
        return self._delete(tables.command_answers, _answer.made_at < moment)
