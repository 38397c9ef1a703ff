"""What the onboard screen shows: the newest view, and what was said and answered of late."""

from collections import deque

import msgspec

from contract.wire.messages import HelpRequested
from vehicle_agent.onboard.cabin_view import CabinEventView, CabinView

KEPT = 5


class ShownAnnouncement(msgspec.Struct, frozen=True):
    """number counts the announcements, so that each is spoken once."""

    number: int
    text: str
    text_zh: str
    age_s: float


class ShownAnswer(msgspec.Struct, frozen=True):
    """What a passenger did, as the vehicle took it."""

    number: int
    body: CabinEventView
    age_s: float


class ScreenScene(msgspec.Struct, frozen=True):
    """One message to a screen.

    seats              of the shuttle, each with a button
    view, view_age_s   the newest view; both None before the first one
    help_age_s         since the last call for help, None without one
    """

    vehicle_id: str
    seats: int
    view: CabinView | None
    view_age_s: float | None
    announcements: tuple[ShownAnnouncement, ...]
    answers: tuple[ShownAnswer, ...]
    help_age_s: float | None


class ScreenHistory:
    """Collects the views of the tick, and says what a screen shows at a time."""

    def __init__(self, vehicle_id: str, seats: int) -> None:
        self._vehicle_id, self._seats = vehicle_id, seats
        self._view: CabinView | None = None
        self._view_ns = 0
        self._announcements: deque[tuple[int, int, str, str]] = deque(maxlen=KEPT)
        self._answers: deque[tuple[int, int, CabinEventView]] = deque(maxlen=KEPT)
        self._count = 0
        self._help_ns: int | None = None

    def take(self, view: CabinView, now_ns: int) -> None:
        self._view, self._view_ns = view, now_ns
        if view.announce or view.announce_zh:
            self._count += 1
            self._announcements.append((self._count, now_ns, view.announce, view.announce_zh))
        for answer in view.answers:
            self._count += 1
            self._answers.append((self._count, now_ns, answer))
            if isinstance(answer, HelpRequested):
                self._help_ns = now_ns

    def scene(self, now_ns: int) -> ScreenScene:
        return ScreenScene(
            vehicle_id=self._vehicle_id,
            seats=self._seats,
            view=self._view,
            view_age_s=None if self._view is None else _age_s(self._view_ns, now_ns),
            announcements=tuple(
                ShownAnnouncement(number, text, text_zh, _age_s(since_ns, now_ns))
                for number, since_ns, text, text_zh in self._announcements
            ),
            answers=tuple(
                ShownAnswer(number, body, _age_s(at_ns, now_ns)) for number, at_ns, body in self._answers
            ),
            help_age_s=None if self._help_ns is None else _age_s(self._help_ns, now_ns),
        )


def _age_s(since_ns: int, now_ns: int) -> float:
    return round((now_ns - since_ns) * 1e-9, 2)
