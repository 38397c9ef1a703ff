"""Arrays in states and records come back equal bit for bit."""

from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from contract.runlog.arrays import dec_hook, enc_hook


class Held(msgspec.Struct):
    plain: np.ndarray
    typed: NDArray[np.float64]


def through(value: Any, kind: Any) -> Any:
    return msgspec.msgpack.decode(
        msgspec.msgpack.encode(value, enc_hook=enc_hook), type=kind, dec_hook=dec_hook
    )


@pytest.mark.parametrize(
    "array",
    [
        np.array([[1.5, -0.0, np.nan], [np.inf, 1e-300, 2.0]]),
        np.empty((0, 3)),
        np.array(4.0),
        np.arange(6, dtype=np.int32)[::2],
        np.array([[1, 2], [3, 4]]).T,
        np.array([True, False]),
    ],
    ids=["floats", "empty", "scalar", "every other one", "transposed", "booleans"],
)
def test_an_array_keeps_its_shape_type_and_every_bit_and_can_be_written_to(array: np.ndarray) -> None:
    back = through(Held(array, array), Held)
    for found in (back.plain, back.typed):
        assert (found.shape, found.dtype) == (array.shape, array.dtype)
        assert found.tobytes() == np.ascontiguousarray(array).tobytes()
        assert found.flags.writeable
        assert found.flags.c_contiguous


def test_a_numpy_number_travels_as_a_plain_one() -> None:
    assert through(np.float64(0.1), float) == 0.1
    assert through(np.int64(7), int) == 7


def test_what_is_neither_array_nor_number_has_no_place_in_a_record() -> None:
    with pytest.raises(NotImplementedError, match="object has no place"):
        msgspec.msgpack.encode(object(), enc_hook=enc_hook)
    with pytest.raises(NotImplementedError, match="cannot be decoded"):
        dec_hook(complex, (1.0, 2.0))
