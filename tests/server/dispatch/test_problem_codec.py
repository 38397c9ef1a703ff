"""Stored problems: restored exactly, or refused, and never read with another version's meaning."""

import zlib
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings

from server.dispatch.problem import Problem
from server.dispatch.problem_codec import FORMAT, ProblemUnreadable, decode_problem, encode_problem
from tests.server.dispatch.problems import problems


@given(problems())
@settings(max_examples=30)
def test_a_stored_problem_is_restored_exactly(problem: Problem) -> None:
    again = decode_problem(encode_problem(problem))
    assert np.array_equal(again.times, problem.times)
    for before, after in zip(problem.vehicles, again.vehicles, strict=True):
        assert np.array_equal(before.to_places_s, after.to_places_s)
        assert replace(before, to_places_s=after.to_places_s) == after
    assert again.requests == problem.requests
    assert again.weights == problem.weights


@pytest.mark.parametrize("form", [FORMAT - 1, FORMAT + 1])
@given(problem=problems())
@settings(max_examples=1)
def test_a_problem_of_another_format_is_refused(form: int, problem: Problem) -> None:
    _, body = msgspec.msgpack.decode(zlib.decompress(encode_problem(problem)))
    with pytest.raises(ProblemUnreadable, match=f"format {form}"):
        decode_problem(zlib.compress(msgspec.msgpack.encode((form, body))))


def test_a_problem_without_a_format_is_one_of_before_there_were_formats() -> None:
    with pytest.raises(ProblemUnreadable):
        decode_problem(zlib.compress(msgspec.msgpack.encode({"requests": {}, "vehicles": []})))


@pytest.mark.parametrize("content", [b"", b"not compressed", zlib.compress(b"\xc1")])
def test_what_is_no_problem_is_refused(content: bytes) -> None:
    with pytest.raises(ProblemUnreadable):
        decode_problem(content)
