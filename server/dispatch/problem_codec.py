"""Snapshots as bytes, so that a decision can be repeated. All numbers are restored exactly."""

import zlib

import msgspec
import numpy as np

from server.dispatch.problem import Problem

# Changed with the fields of a problem, so that none is decided again with another one's meaning.
# 2: travel time factors have their name; they were called paces.
FORMAT = 2
# Bookings wait for this: level 1 takes a third of the time of the default, for a tenth more bytes.
_LEVEL = 1


class ProblemUnreadable(ValueError):
    """The bytes are no stored problem, or one of another version of the dispatcher."""


def encode_problem(problem: Problem) -> bytes:
    return zlib.compress(_ENCODER.encode((FORMAT, problem)), _LEVEL)


def decode_problem(content: bytes) -> Problem:
    """Raises ProblemUnreadable."""
    try:
        form, problem = _DECODER.decode(zlib.decompress(content))
    except (zlib.error, msgspec.MsgspecError) as error:
        raise ProblemUnreadable(str(error)) from error
    if form != FORMAT:
        raise ProblemUnreadable(f"written in format {form}; this version reads format {FORMAT}")
    return problem


def _to_plain(value: object) -> object:
    if isinstance(value, np.ndarray):
        return [list(value.shape), value.astype("<f8").tobytes()]
    raise NotImplementedError(f"{type(value)} is not part of a problem")


def _from_plain(_: type, value: tuple[list[int], bytes]) -> object:
    shape, content = value
    return np.frombuffer(content, "<f8").reshape(shape).copy()


_ENCODER = msgspec.msgpack.Encoder(enc_hook=_to_plain)
_DECODER = msgspec.msgpack.Decoder(tuple[int, Problem], dec_hook=_from_plain)
