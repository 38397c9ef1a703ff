"""What the server forgets, and when."""

from datetime import timedelta

from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.answers import forget_old_answers
from server.usecases.record.audit import forget_old_addresses


def forget_old(uow: UnitOfWork) -> int:
    """Drop positions and decisions older than the rules say, and sessions and answers to
    commands that are over, and addresses in the audit log; how many rows."""
    oldest = uow.now - timedelta(days=uow.rules.history_days)
    kept = uow.history.forget_before(oldest) + uow.decisions.forget_before(oldest)
    kept += forget_old_addresses(uow)
    return kept + uow.identity.forget_sessions_before(uow.now) + forget_old_answers(uow)
