"""Second factors of operators: six digits that change every 30 seconds (TOTP, RFC 6238)."""

from dataclasses import dataclass
from datetime import datetime, timedelta

# The authenticator's clock may be one step off, as RFC 6238 recommends.
STEP_S = 30
STEPS_OFF = 1
# So many wrong codes in a row lock the factor: the chance to guess one of them is 60 in a million.
WRONG_CODES_MAX = 20


@dataclass(frozen=True, slots=True)
class SecondFactor:
    """Its secret is derived from a ticket key and its id, and stored nowhere.

    confirmed_at     when the operator first gave a code of it; before, it counts for nothing
    last_step        the step of the newest code that was used: each works once
    wrong_codes      in a row
    recovery_sha256  of the recovery codes that are left
    """

    campus_id: str
    factor_id: str
    operator_id: str
    ticket_key_id: str
    made_at: datetime
    confirmed_at: datetime | None = None
    last_step: int = 0
    wrong_codes: int = 0
    recovery_sha256: frozenset[str] = frozenset()

    @property
    def is_locked(self) -> bool:
        return self.wrong_codes >= WRONG_CODES_MAX

    def holds(self, checked_at: datetime | None, now: datetime, lifetime_s: float) -> bool:
        """It was checked then, and need not be checked again yet."""
        if checked_at is None or self.confirmed_at is None or checked_at < self.confirmed_at:
            return False
        return now < checked_at + timedelta(seconds=lifetime_s)


def steps_around(moment: datetime) -> range:
    """The steps whose codes are taken at this moment."""
    step = int(moment.timestamp()) // STEP_S
    return range(step - STEPS_OFF, step + STEPS_OFF + 1)
