"""Refusals of keys, names, sessions of operators and developer tokens."""

from server.domain.errors.base import DomainError


class KeyUnknown(DomainError):
    """No valid key is enrolled for this vehicle, or the signature does not fit it."""

    code = "key_unknown"


class KeyInvalid(DomainError):
    """Not an Ed25519 public key in base64."""

    code = "key_invalid"


class EnrolmentCodeUnknown(DomainError):
    """No such enrolment code, or it has expired."""

    code = "enrolment_code_unknown"


class EnrolmentCodeUsed(DomainError):
    """An enrolment code works once."""

    code = "enrolment_code_used"


class NameTaken(DomainError):
    """The name is already in use."""

    code = "name_taken"


class WrongCredentials(DomainError):
    """Name and password do not match; the answer does not say which one is wrong."""

    code = "wrong_credentials"


class SessionExpired(DomainError):
    """The operator's session is over or was never opened: log in again."""

    code = "session_expired"


class TokenInvalid(DomainError):
    """The developer token is unknown, expired or revoked."""

    code = "token_invalid"


class ScopeMissing(DomainError):
    """The developer token does not allow this."""

    code = "scope_missing"


class TicketKeyMissing(DomainError):
    """Rides or recurring bookings have links that were made with a key that this server does not have."""

    code = "ticket_key_missing"
