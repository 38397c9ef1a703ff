"""A command with an idempotency key is carried out once; a repeat gets the first answer."""

from collections.abc import Callable
from datetime import timedelta
from typing import TypeVar

from server.domain.errors import IdempotencyMismatch
from server.domain.record.answers import KeyedRequest
from server.usecases.ports.unit_of_work import UnitOfWork

T = TypeVar("T")

# A client that repeats a command does so within minutes; an unattended script within the night.
KEPT = timedelta(days=1)


class AnsweredBefore(Exception):
    """The command was carried out by an earlier transaction; `sealed` is its answer."""

    def __init__(self, sealed: bytes) -> None:
        super().__init__()
        self.sealed = sealed


def answer_once(
    uow: UnitOfWork, request: KeyedRequest, work: Callable[[UnitOfWork], T], seal: Callable[[T], bytes]
) -> T:
    """What `work` returns, stored in the same transaction under the request's key.

    A refusal is not stored: a repeat tries again. Raises AnsweredBefore, IdempotencyMismatch.
    """
    known = uow.answers.claim(request, uow.now)
    if known is not None:
        if known.request.request_sha256 != request.request_sha256:
            raise IdempotencyMismatch("this Idempotency-Key belongs to another command; use a new one")
        raise AnsweredBefore(known.sealed)
    result = work(uow)
    uow.answers.complete(request, seal(result))
    return result


def forget_old_answers(uow: UnitOfWork) -> int:
    """How many answers were dropped; their keys can be used again."""
    return uow.answers.forget_before(uow.now - KEPT)
