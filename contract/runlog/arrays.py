"""numpy arrays inside msgspec values: hooks that every encoder and decoder of states and records shares.

An array travels as (shape, dtype, bytes), so that what comes back is equal bit for bit.
"""

import numpy as np


def enc_hook(value: object) -> object:
    """For `msgspec` encoders. NotImplementedError for anything but arrays and numpy scalars."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, np.ascontiguousarray(value).tobytes()
    if isinstance(value, np.generic):
        return value.item()
    raise NotImplementedError(f"{type(value).__name__} has no place in a state or a record")


def dec_hook(kind: object, value: tuple[tuple[int, ...], str, bytes]) -> object:
    """For `msgspec` decoders; gives a writable, C-contiguous copy: what the kernels are compiled for."""
    if getattr(kind, "__origin__", kind) is np.ndarray:
        shape, dtype, data = value
        return np.frombuffer(data, dtype=np.dtype(dtype)).reshape(shape).copy()
    raise NotImplementedError(f"{kind} cannot be decoded")
