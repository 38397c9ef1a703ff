"""Commands of operators and developers to a vehicle, and taps of passengers."""

from typing import Literal

from contract.wire.base import Message


class Command(Message, frozen=True, tag="command"):
    """An operator's or developer's word to one vehicle. Repeats of a command_id are harmless."""

    epoch: int
    command_id: str
    kind: Literal["hold", "resume", "announce", "stop_now"]
    text: str = ""


class PassengerTap(Message, frozen=True, tag="passenger_tap"):
    """A passenger tapped on the phone. The vehicle accepts it only while it stands with doors open."""

    epoch: int
    tap_id: str
    ride_id: str
    kind: Literal["board", "alight"]
