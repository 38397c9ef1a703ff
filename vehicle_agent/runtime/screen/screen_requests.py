"""What the onboard screen may ask for, and how often."""

from collections import deque

import msgspec

from contract.wire.bounds import PlaceId, RideCode, Seats
from vehicle_agent.signals import CodeTyped, DestinationChoice, HelpButton, SeatButton

REQUEST_BYTES_MAX = 1_000
# Of all screens together. A code has four digits: guesses must be few.
CODES_MAX, CODES_NS = 5, 30_000_000_000
REQUESTS_MAX, REQUESTS_NS = 20, 10_000_000_000


class StopRequest(msgspec.Struct, frozen=True, tag="stop"):
    """Get off before the planned stop."""

    seat: Seats


class HelpRequest(msgspec.Struct, frozen=True, tag="help"):
    """Call the operators."""


class CodeRequest(msgspec.Struct, frozen=True, tag="code"):
    """Board or get off by the boarding code."""

    code: RideCode


class DestinationRequest(msgspec.Struct, frozen=True, tag="destination"):
    """Go to another stop. code: of the party, "" if it is the only one aboard."""

    stop_id: PlaceId
    code: RideCode = ""


ScreenRequest = StopRequest | HelpRequest | CodeRequest | DestinationRequest
CabinInput = SeatButton | HelpButton | CodeTyped | DestinationChoice

_decoder: msgspec.json.Decoder[ScreenRequest] = msgspec.json.Decoder(ScreenRequest)


def decode_request(data: str | bytes) -> ScreenRequest | None:
    """None for what is no request."""
    try:
        return _decoder.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None


def cabin_input(request: ScreenRequest, now_ns: int) -> CabinInput:
    """The request as a value of the inbox, as a button or keypad gives it."""
    match request:
        case StopRequest():
            return SeatButton(now_ns, request.seat)
        case HelpRequest():
            return HelpButton(now_ns)
        case CodeRequest():
            return CodeTyped(now_ns, request.code)
        case DestinationRequest():
            return DestinationChoice(now_ns, request.code, request.stop_id)


class RequestLimit:
    """Bounds the requests of all screens together; a call for help is bounded by itself only."""

    def __init__(self) -> None:
        self._taken: dict[str, deque[int]] = {"code": deque(), "help": deque(), "other": deque()}

    def take(self, request: ScreenRequest, now_ns: int) -> bool:
        """False: too many of late, and the request is not taken."""
        if isinstance(request, HelpRequest):
            return self._take("help", REQUESTS_MAX, REQUESTS_NS, now_ns)
        with_code = isinstance(request, CodeRequest | DestinationRequest) and bool(request.code)
        if with_code and not self._take("code", CODES_MAX, CODES_NS, now_ns):
            return False
        return self._take("other", REQUESTS_MAX, REQUESTS_NS, now_ns)

    def _take(self, kind: str, count: int, within_ns: int, now_ns: int) -> bool:
        taken = self._taken[kind]
        while taken and now_ns - taken[0] >= within_ns:
            taken.popleft()
        if len(taken) >= count:
            return False
        taken.append(now_ns)
        return True
