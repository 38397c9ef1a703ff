"""Formats that several schemas share: names in paths, free text, moments."""

from datetime import UTC, datetime
from typing import Annotated

from fastapi import Path
from pydantic import AfterValidator, AwareDatetime, Field, StringConstraints

NAME_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._@:-]{0,63}$"
TOKEN_PATTERN = r"^[A-Za-z0-9_-]{16,128}$"
SHA256_PATTERN = r"^[0-9a-f]{64}$"

Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN)]
# Text that people write: no control characters, so that it can be shown and stored anywhere.
FreeText = Annotated[
    str, StringConstraints(strip_whitespace=True, max_length=500, pattern=r"^[^\x00-\x08\x0b-\x1f]*$")
]
StopId = Annotated[str, StringConstraints(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f]+$")]


def _within_calendar(moment: datetime) -> datetime:
    """Near the calendar's ends a moment has no equal in other time zones."""
    if not _FIRST <= moment <= _LAST:
        raise ValueError(f"must lie between {_FIRST:%Y} and {_LAST:%Y}")
    return moment


_FIRST, _LAST = datetime(1970, 1, 1, tzinfo=UTC), datetime(2999, 12, 31, tzinfo=UTC)
Moment = Annotated[AwareDatetime, AfterValidator(_within_calendar), Field(examples=["2026-09-01T08:15:00Z"])]

RideToken = Annotated[
    str,
    Path(
        pattern=TOKEN_PATTERN,
        description="The secret of the passenger's link, from the answer to the booking.",
        examples=["q3Jv0X2mQp7sT4uYb1cD9w"],
    ),
]
RideId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["ride-5f2c"])]
VehicleId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["shuttle-1"])]
BootId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["boot-7a1e"])]
IncidentId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["incident-19"])]
TokenId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["token-3"])]
WebhookId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["webhook-4"])]
TapId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["tap-8"])]
Sha256 = Annotated[
    str,
    Path(
        pattern=SHA256_PATTERN,
        examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"],
    ),
]
