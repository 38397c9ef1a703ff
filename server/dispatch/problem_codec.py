"""Snapshots as bytes, so that a decision can be repeated. All numbers are restored exactly."""

import zlib

import msgspec
import numpy as np

from server.dispatch.problem import Problem

# Bookings wait for this: level 1 takes a third of the time of the default, for a tenth more bytes.
_LEVEL = 1


class ProblemUnreadable(ValueError):
    """The bytes are no stored problem, or one of another version of the dispatcher."""


def encode_problem(problem: Problem) -> bytes:
    return zlib.compress(_ENCODER.encode(problem), _LEVEL)


def decode_problem(content: bytes) -> Problem:
    """Raises ProblemUnreadable."""
    try:
        return _DECODER.decode(zlib.decompress(content))
    except (zlib.error, msgspec.MsgspecError) as error:
        raise ProblemUnreadable(str(error)) from error


def _to_plain(value: object) -> object:
    if isinstance(value, np.ndarray):
        return [list(value.shape), value.astype("<f8").tobytes()]
    raise NotImplementedError(f"{type(value)} is not part of a problem")


def _from_plain(_: type, value: tuple[list[int], bytes]) -> object:
    shape, content = value
    return np.frombuffer(content, "<f8").reshape(shape).copy()


_ENCODER = msgspec.msgpack.Encoder(enc_hook=_to_plain)
_DECODER = msgspec.msgpack.Decoder(Problem, dec_hook=_from_plain)
