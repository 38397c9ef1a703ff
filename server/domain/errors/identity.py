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


class RoleMissing(DomainError):
    """None of the operator's roles allows this."""

    code = "role_missing"


class OperatorUnknown(DomainError):
    """No operator has this name."""

    code = "operator_unknown"


class LastAdmin(DomainError):
    """Without this operator nobody could give access to others."""

    code = "last_admin"


class PasswordChangeNeeded(DomainError):
    """The password was given by somebody else: choose your own first."""

    code = "password_change_needed"


class PasswordInSettings(DomainError):
    """The password of this operator is a setting of the server, and is changed there."""

    code = "password_in_settings"


class SecondFactorNeeded(DomainError):
    """The session's second factor was not checked lately."""

    code = "second_factor_needed"


class SecondFactorMissing(DomainError):
    """The operator has no second factor, and this server asks for one here."""

    code = "second_factor_missing"


class SecondFactorLocked(DomainError):
    """Too many wrong codes in a row: only a recovery code or another admin helps."""

    code = "second_factor_locked"


class WrongCode(DomainError):
    """The code is wrong, was used already, or is over."""

    code = "wrong_code"


class TicketKeyMissing(DomainError):
    """Rides or recurring bookings have links that were made with a key that this server does not have."""

    code = "ticket_key_missing"
