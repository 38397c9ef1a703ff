"""The errors of the client.

CampusError
 +-- RequestRefused     the server answered that it does not do this; `code` is for programs
 |    +-- NotAllowed    the token is unknown, expired, revoked, or lacks the scope
 |    +-- NotFound      no ride, vehicle, stop or closure has this id
 |    +-- Conflict      the state of the ride, vehicle or campus does not allow it
 |    +-- Invalid       the request does not fit its schema or makes no sense; `fields` says where
 |    +-- TooMany       too many requests; `retry_after_s` says how long to wait
 +-- ServerFault        the server failed; its log names the cause
 +-- ConnectionLost     no answer came; the command may have been carried out or not
 +-- AnswerUnreadable   the answer is not one that this version of the client knows
"""

from dataclasses import dataclass


class CampusError(Exception):
    """Base of everything that a call may raise."""


@dataclass(frozen=True, slots=True)
class FieldProblem:
    """One field of the request that does not fit."""

    where: str
    message: str


class RequestRefused(CampusError):
    """The server refused a request.

    code    stable, for programs; the text says what to do
    rule    the dispatcher's rule that binds, "" when none is the reason
    """

    def __init__(
        self,
        code: str,
        detail: str,
        *,
        status: int = 0,
        rule: str = "",
        fields: tuple[FieldProblem, ...] = (),
        retry_after_s: float = 0.0,
    ) -> None:
        super().__init__(f"{detail} ({code})")
        self.code, self.detail, self.status = code, detail, status
        self.rule, self.fields, self.retry_after_s = rule, fields, retry_after_s


class NotAllowed(RequestRefused):
    """The token is unknown, expired, revoked, or lacks the scope."""


class NotFound(RequestRefused):
    """No ride, vehicle, stop or closure has this id."""


class Conflict(RequestRefused):
    """The state of the ride, vehicle or campus does not allow it."""


class Invalid(RequestRefused):
    """The request does not fit its schema or makes no sense."""


class TooMany(RequestRefused):
    """Too many requests."""


class ServerFault(CampusError):
    """The server failed; its log names the cause."""


class ConnectionLost(CampusError):
    """No answer came, in spite of repeats; the text says why."""


class AnswerUnreadable(CampusError):
    """The answer is not one that this version of the client knows."""


BY_STATUS: dict[int, type[RequestRefused]] = {
    400: Invalid,
    401: NotAllowed,
    403: NotAllowed,
    404: NotFound,
    409: Conflict,
    413: Invalid,
    422: Invalid,
    429: TooMany,
}
