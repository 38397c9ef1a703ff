"""An infrastructure camera at an observation area: counts the people in it, late, noisy and not always.

It says how many and nothing about who or whereto (NUS, section V-A): any detection makes vehicles slow down.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from contract.roads.areas import inside, outline_array
from contract.roads.model import ObservationArea
from contract.wire.messages import PresenceReport


class CameraError(Exception):
    """A camera that cannot be; the message says what to change."""


@dataclass(frozen=True, slots=True)
class CameraParams:
    """rate_hz      words a second; the paper's camera gave 5, security cameras about 1
    miss           a person in view is not detected, each in each picture
    ghost          a person who is not there is detected, in each picture
    latency_s      from the picture to the word, the detector's time included
    dropout        a word is lost on its way
    down           from, to (s of world time) in which it says nothing at all
    """

    rate_hz: float = 5.0
    miss: float = 0.05
    ghost: float = 0.005
    latency_s: float = 0.15
    dropout: float = 0.02
    down: tuple[tuple[float, float], ...] = ()


class CrossingCamera:
    """Pictures are taken at even times; a word comes `latency_s` later. One random stream of its own."""

    def __init__(self, area: ObservationArea, params: CameraParams, rng: np.random.Generator) -> None:
        """CameraError outside 1..10 words a second or for a share that is none."""
        shares = (params.miss, params.ghost, params.dropout)
        if not (1.0 <= params.rate_hz <= 10.0 and params.latency_s >= 0.0):
            raise CameraError(f"a camera speaks 1..10 times a second and never early, not {params}")
        if not all(0.0 <= share <= 1.0 for share in shares):
            raise CameraError(f"miss, ghost and dropout are shares of 1, not {shares}")
        self.area_id = area.area_id
        self._outline = outline_array(area)
        self._params, self._rng = params, rng
        self._period_ns = round(1e9 / params.rate_hz)
        self._due_ns: int | None = None
        self._words: deque[tuple[int, int, int]] = deque()

    def step(self, now_ns: int, people: Array) -> tuple[PresenceReport, ...]:
        """The words that come out now; people (n, 2) where everybody is, map frame."""
        if self._due_ns is None:
            self._due_ns = now_ns
        while now_ns >= self._due_ns:
            self._picture(self._due_ns, people)
            self._due_ns += self._period_ns
        said = []
        while self._words and self._words[0][0] <= now_ns:
            _, taken_ns, count = self._words.popleft()
            said.append(PresenceReport(self.area_id, count, (now_ns - taken_ns) * 1e-9))
        return tuple(said)

    def _picture(self, taken_ns: int, people: Array) -> None:
        params = self._params
        there = int(np.count_nonzero(inside(self._outline, people))) if len(people) else 0
        # Equal numbers of draws whatever happens: one lost word does not change all that follow.
        misses, ghost, lost = self._rng.random(there), self._rng.random(), self._rng.random()
        count = int(np.count_nonzero(misses >= params.miss)) + int(ghost < params.ghost)
        is_down = any(begin <= taken_ns * 1e-9 < end for begin, end in params.down)
        if lost >= params.dropout and not is_down:
            self._words.append((taken_ns + round(params.latency_s * 1e9), taken_ns, count))
