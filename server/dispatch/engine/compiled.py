"""How the engine's kernels are compiled.

A kernel works on arrays that its caller holds, and makes none of its own, so it need not count references.
With some thirty arrays in a task and a plan, counting took three quarters of a search's time.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

# `_nrt` is numba's own switch for the counting. The results are the same with it, only slower.
_OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}
_Kernel = TypeVar("_Kernel", bound=Callable[..., Any])


def kernel(function: _Kernel) -> _Kernel:
    return cast(_Kernel, njit(**_OPTIONS)(function))


def inlined(function: _Kernel) -> _Kernel:
    """A short kernel that is inlined into its callers."""
    return cast(_Kernel, njit(**_OPTIONS, inline="always")(function))
