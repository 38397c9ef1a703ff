"""The onboard state as bytes and back, so that each run-log segment can be replayed alone."""

import msgspec

from contract.runlog.arrays import dec_hook, enc_hook
from vehicle_agent.onboard.car import Car, initial_state
from vehicle_agent.onboard.state import OnboardState

_encoder = msgspec.msgpack.Encoder(enc_hook=enc_hook)


def encode_state(state: OnboardState) -> bytes:
    """MessagePack of every room's state, by room name."""
    rooms = {name: msgspec.Raw(_encoder.encode(getattr(state, name))) for name in state.__struct_fields__}
    return _encoder.encode(rooms)


def decode_state(data: bytes, car: Car) -> OnboardState:
    """The state of this car's rooms. Raises msgspec.DecodeError for the state of another stack."""
    rooms = msgspec.msgpack.decode(data, type=dict[str, msgspec.Raw])
    pattern = initial_state(car)
    decoded = {
        name: msgspec.msgpack.decode(rooms[name], type=type(getattr(pattern, name)), dec_hook=dec_hook)
        for name in pattern.__struct_fields__
    }
    return OnboardState(**decoded)
