"""Results that are computed again only when one of the objects that they were made of is another one."""

from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")
_KEPT = 50_000


class CachedResults:
    """Results by name; each is valid while the objects that it was made of are the same."""

    def __init__(self) -> None:
        self._cached: dict[str, tuple[tuple[object, ...], Any]] = {}

    def get(self, name: str, parts: tuple[object, ...], make: Callable[[], T]) -> T:
        """The result made of these immutable objects; computed again if one of them is another object."""
        known = self._cached.get(name)
        if known is not None and all(a is b for a, b in zip(known[0], parts, strict=True)):
            found: T = known[1]
            return found
        if len(self._cached) >= _KEPT:
            self._cached.clear()
        made = make()
        self._cached[name] = parts, made
        return made
