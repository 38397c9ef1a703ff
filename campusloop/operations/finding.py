"""What one check of an installation has found."""

from dataclasses import dataclass
from typing import Literal

State = Literal["good", "warning", "bad"]


@dataclass(frozen=True, slots=True)
class Finding:
    """remedy: what to do, empty if the state is good."""

    check: str
    state: State
    text: str
    remedy: str = ""


def good(check: str, text: str) -> Finding:
    return Finding(check, "good", text)


def warning(check: str, text: str, remedy: str) -> Finding:
    return Finding(check, "warning", text, remedy)


def bad(check: str, text: str, remedy: str) -> Finding:
    return Finding(check, "bad", text, remedy)
