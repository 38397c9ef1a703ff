"""One name for arrays of whole numbers, times and truths alike; shapes and kinds are in the docstrings."""

from typing import Any

from numpy.typing import NDArray

AnyArray = NDArray[Any]
