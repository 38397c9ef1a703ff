"""Repeats stored decisions from their snapshots and describes the first difference."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import msgspec

from server.domain.planning.decisions import Decision
from server.usecases.planning.decisions import DecisionUnreadable, repeated


@dataclass(frozen=True, slots=True)
class RepeatedDecision:
    """difference: a description, "" if the answers are identical bytes"""

    decision: Decision
    difference: str

    @property
    def equal(self) -> bool:
        return not self.difference


def repeat_all(decisions: Iterable[Decision]) -> Iterator[RepeatedDecision]:
    for decision in decisions:
        yield RepeatedDecision(decision, _difference(decision))


def _difference(decision: Decision) -> str:
    try:
        again = repeated(decision)
    except DecisionUnreadable as error:
        return f"it cannot be repeated, its record is of another version: {error}"
    if again == decision.answer:
        return ""
    before, now = msgspec.json.decode(decision.answer), msgspec.json.decode(again)
    return _first(before, now, "") or "the values are equal and their encoding differs"


def _first(before: Any, now: Any, where: str) -> str:
    """The first difference of two plain values, "" if they are equal."""
    if isinstance(before, dict) and isinstance(now, dict) and before.keys() == now.keys():
        return next(filter(None, (_first(before[k], now[k], _inside(where, k, before)) for k in before)), "")
    if isinstance(before, list) and isinstance(now, list):
        if len(before) != len(now):
            return f"{where or 'the answer'} had {len(before)} entries, now {len(now)}"
        pairs = enumerate(zip(before, now, strict=True))
        return next(filter(None, (_first(a, b, f"{where}[{k}]") for k, (a, b) in pairs)), "")
    if before == now and type(before) is type(now):
        return ""
    return f"{where or 'the answer'} was {_short(before)}, now {_short(now)}"


def _inside(where: str, key: str, of: dict[str, Any]) -> str:
    """The path of a field; rides and shuttles are named by their ids."""
    name = of.get("request_id") or of.get("vehicle_id")
    here = f"{name}" if name and not where.endswith(str(name)) else where
    return f"{here} {key}".strip()


def _short(value: Any) -> str:
    text = "nothing" if value is None else msgspec.json.encode(value).decode()
    return text if len(text) <= 80 else f"{text[:77]}..."
