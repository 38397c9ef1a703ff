"""Why a link is closed, as data: one row a reason, the same table for both sides.

The server says `Goodbye(code, detail)` and then closes the websocket with the row's number. `retry` tells
the vehicle what to do next. A close loses no events, because they stay in the vehicle's outbox until they are
acknowledged.
"""

from typing import Literal

import msgspec

CloseCode = Literal[
    "malformed",
    "unknown_message",
    "frame_too_large",
    "protocol_version",
    "hello_expected",
    "hello_late",
    "hello_repeated",
    "nonce_wrong",
    "signature_wrong",
    "key_unknown",
    "epoch_stale",
    "superseded",
    "key_conflict",
    "too_slow",
    "server_leaving",
    "server_fault",
]
Retry = Literal["at_once", "later", "after_repair"]


class CloseReason(msgspec.Struct, frozen=True):
    """number  the websocket close code (4000-4999 is for applications)
    retry   at_once: dial again now; later: back off first; after_repair: useless until a person acts
    advice  what that person or the agent should do
    """

    code: CloseCode
    number: int
    retry: Retry
    advice: str


CLOSE_REASONS: tuple[CloseReason, ...] = (
    CloseReason("malformed", 4400, "later", "The frame is no valid message; compare it with docs/protocol."),
    CloseReason("unknown_message", 4404, "later", "Update the side that is older, or drop the message."),
    CloseReason("frame_too_large", 4413, "later", "Send smaller frames; upload run segments over HTTP."),
    CloseReason("protocol_version", 4426, "after_repair", "Update the agent's software to a spoken version."),
    CloseReason(
        "hello_expected", 4401, "later", "Answer the challenge with a signed hello before anything else."
    ),
    CloseReason("hello_late", 4408, "later", "Send the hello within the time allowed after the challenge."),
    CloseReason("hello_repeated", 4409, "later", "A nonce opens one session once; dial again for a new one."),
    CloseReason(
        "nonce_wrong", 4410, "later", "Sign the nonce of this very connection; old hellos open nothing."
    ),
    CloseReason("signature_wrong", 4403, "after_repair", "Enrol the vehicle's present key with a new code."),
    CloseReason(
        "key_unknown",
        4405,
        "after_repair",
        "Enrol the vehicle with a code made in the console; a revoked key too.",
    ),
    CloseReason("epoch_stale", 4411, "at_once", "Use the epoch of the last welcome in every frame."),
    CloseReason("superseded", 4412, "later", "A newer session of this vehicle is open; only it is heard."),
    CloseReason(
        "key_conflict",
        4414,
        "later",
        "Two agents use one key: stop one, or enrol it as a vehicle of its own; then close the incident.",
    ),
    CloseReason("too_slow", 4429, "at_once", "The agent does not read fast enough; dial again to resume."),
    CloseReason(
        "server_leaving",
        4503,
        "at_once",
        "The server is stopping; dial again now: another one, or soon this one, answers.",
    ),
    CloseReason(
        "server_fault", 4500, "later", "The server failed to handle a frame; its log names the cause."
    ),
)

_BY_CODE = {row.code: row for row in CLOSE_REASONS}
_BY_NUMBER = {row.number: row for row in CLOSE_REASONS}


def close_reason(code: CloseCode) -> CloseReason:
    return _BY_CODE[code]


def retry_after(code: str) -> Retry:
    """What to do after a goodbye with this code; later for one that only a newer server knows."""
    row = next((row for row in CLOSE_REASONS if row.code == code), None)
    return "later" if row is None else row.retry


def close_reason_of_number(number: int) -> CloseReason | None:
    """The row of a websocket close code; None for codes of the websocket protocol itself (1000-3999)."""
    return _BY_NUMBER.get(number)
