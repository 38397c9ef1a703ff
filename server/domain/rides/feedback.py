"""What a passenger says of a ride that is over: a rating, and what was left in the shuttle."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True, slots=True)
class Feedback:
    """rating         1 (bad) to 5 (good), None for none
    lost_property  what was left in the shuttle, in the passenger's words; "" for nothing
    """

    campus_id: str
    ride_id: str
    rating: int | None
    lost_property: str
    made_at: datetime
