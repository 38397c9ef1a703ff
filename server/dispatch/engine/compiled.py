"""How the engine's kernels are compiled.

A kernel works on arrays that its caller holds, and makes none of its own; so it need not count references to
them. With some thirty arrays in a task and a plan, counting was three quarters of a search's time.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

# `_nrt` is numba's own switch for the counting; without it all is the same but slower.
_OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}
_Kernel = TypeVar("_Kernel", bound=Callable[..., Any])


def kernel(function: _Kernel) -> _Kernel:
    return cast(_Kernel, njit(**_OPTIONS)(function))


def inlined(function: _Kernel) -> _Kernel:
    """A kernel of few lines, which becomes a part of those that call it."""
    return cast(_Kernel, njit(**_OPTIONS, inline="always")(function))
