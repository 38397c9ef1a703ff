"""An attack: what it tries, the control that stops it, and how that control is taken away."""

from collections.abc import Awaitable, Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

from benchmarks.attacks.target import Target

Attempt = Callable[[Target], Awaitable[bool]]


@dataclass(frozen=True)
class Attack:
    """attempt   whether the attacker got what must not be had
    control   what stops it
    without   (object, attribute, what is there instead) of the control; empty: it cannot be taken away alone
    budgets   needs a server with the default budgets
    """

    name: str
    attempt: Attempt
    control: str
    without: tuple[tuple[Any, str, Any], ...] = ()
    budgets: bool = False

    @contextmanager
    def unprotected(self) -> Iterator[None]:
        with ExitStack() as patches:
            for where, attribute, instead in self.without:
                patches.enter_context(patch.object(where, attribute, instead))
            yield


ATTACKS: list[Attack] = []


def attack(
    control: str, *without: tuple[Any, str, Any], budgets: bool = False
) -> Callable[[Attempt], Attempt]:
    """Enter the function as an attack, under its own name."""

    def enter(attempt: Attempt) -> Attempt:
        ATTACKS.append(Attack(attempt.__name__, attempt, control, without, budgets))
        return attempt

    return enter


def allows(*_: object, **__: object) -> None:
    """Instead of a check that raises."""


async def allows_async(*_: object, **__: object) -> None:
    """Instead of a check that raises."""


def yes(*_: object, **__: object) -> bool:
    """Instead of a check that answers."""
    return True
