"""Commands of operators and developers to a vehicle, and taps of passengers."""

from typing import Literal

from contract.wire.base import Message
from contract.wire.bounds import Count, Id, LongText


class Command(Message, frozen=True, tag="command"):
    """An operator's or developer's word to one vehicle. Repeats of a command_id are harmless."""

    epoch: Count
    command_id: Id
    kind: Literal["hold", "resume", "announce", "stop_now"]
    text: LongText = ""


class PassengerTap(Message, frozen=True, tag="passenger_tap"):
    """A passenger tapped on the phone. The vehicle accepts it only while it stands with doors open."""

    epoch: Count
    tap_id: Id
    ride_id: Id
    kind: Literal["board", "alight"]
