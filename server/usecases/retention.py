"""What the server forgets, and when."""

from datetime import timedelta

from server.usecases.ports import UnitOfWork


def forget_old(uow: UnitOfWork) -> int:
    """Drop positions older than the rules say and operator sessions that are over; how many rows."""
    oldest = uow.now - timedelta(days=uow.rules.history_days)
    return uow.history.forget_before(oldest) + uow.identity.forget_sessions_before(uow.now)
