"""Refusals because the database cannot be used now. Both are answered with 503."""

from server.domain.errors.base import DomainError

RETRY_AFTER_S = 2.0


class StoreFailure(DomainError):
    """The database failed, not the request: whatever else is asked of it now fails as well."""

    retry_after_s = RETRY_AFTER_S


class StoreUnavailable(StoreFailure):
    """The database cannot be used now. Nothing was stored: ask again in some seconds."""

    code = "store_unavailable"


class OutcomeUnknown(StoreFailure):
    """The database was lost during the commit, so the request may have been stored or not. Read before asking
    again, or ask again with the same Idempotency-Key."""

    code = "outcome_unknown"
