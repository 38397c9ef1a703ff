"""Texts about rides that the live and the headless demo share."""

from datetime import datetime
from zoneinfo import ZoneInfo


def promise_text(promise: dict[str, str] | None, zone: ZoneInfo) -> str:
    """A promise of the API in local times, to continue a sentence; "" for none."""
    if promise is None:
        return ""
    pickup_from, pickup_to, arrive_by = (
        datetime.fromisoformat(promise[name]).astimezone(zone)
        for name in ("pickup_from", "pickup_to", "arrive_by")
    )
    return f", pickup {pickup_from:%H:%M}-{pickup_to:%H:%M}, there by {arrive_by:%H:%M}"
