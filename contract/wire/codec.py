"""Bytes <-> message. Text frames of JSON, so that any websocket tool can show the link."""

from typing import TypeVar

import msgspec

from contract.wire.messages import Message, ServerMessage, VehicleMessage

T = TypeVar("T")

MAX_MESSAGE_BYTES = 512 * 1024

_encoder = msgspec.json.Encoder()
_from_vehicle: msgspec.json.Decoder[VehicleMessage] = msgspec.json.Decoder(VehicleMessage)
_from_server: msgspec.json.Decoder[ServerMessage] = msgspec.json.Decoder(ServerMessage)


class WireError(Exception):
    """A frame that is not a valid message of this protocol; `detail` says why."""

    def __init__(self, detail: str) -> None:
        super().__init__(detail)
        self.detail = detail


def encode(message: Message) -> bytes:
    return _encoder.encode(message)


def decode_from_vehicle(data: bytes | str) -> VehicleMessage:
    """Raises WireError for an unknown type, a wrong field or a frame over MAX_MESSAGE_BYTES."""
    return _decode(_from_vehicle, data)


def decode_from_server(data: bytes | str) -> ServerMessage:
    """Raises WireError for an unknown type, a wrong field or a frame over MAX_MESSAGE_BYTES."""
    return _decode(_from_server, data)


def _decode(decoder: "msgspec.json.Decoder[T]", data: bytes | str) -> T:
    if len(data) > MAX_MESSAGE_BYTES:
        raise WireError(f"frame of {len(data)} bytes; at most {MAX_MESSAGE_BYTES} are allowed")
    try:
        return decoder.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise WireError(str(error)) from error
    except RecursionError as error:
        raise WireError("nested too deeply to be a message of this protocol") from error
