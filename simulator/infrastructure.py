"""An infrastructure camera over an observation area. It counts the people, with noise, latency and dropouts.

It reports only the number of people (NUS, section V-A): any detection makes vehicles slow down. The count
comes from the true places with drawn misses and ghosts, or from a detector on simulated pictures.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from contract.roads.areas import inside, outline_array
from contract.roads.model import ObservationArea, RoadMap
from contract.wire.messages import PresenceReport


class CameraError(Exception):
    """Invalid camera parameters; the message says what to change."""


@dataclass(frozen=True, slots=True)
class CameraParams:
    """rate_hz      reports per second; the paper's camera had 5, security cameras have about 1
    miss           probability that a person in view is not detected in a picture; unused with a detector
    ghost          probability of a false detection in a picture; unused with a detector
    latency_s      from the picture to the report, with the detector's time
    dropout        probability that a report is lost
    down           from, to (s of world time) without reports
    """

    rate_hz: float = 5.0
    miss: float = 0.05
    ghost: float = 0.005
    latency_s: float = 0.15
    dropout: float = 0.02
    down: tuple[tuple[float, float], ...] = ()


class CrossingCamera:
    """Takes pictures periodically and reports `latency_s` later. It has a random stream of its own."""

    def __init__(
        self,
        area: ObservationArea,
        params: CameraParams,
        rng: np.random.Generator,
        detect: Callable[[int], int | None] | None = None,
    ) -> None:
        """Raises CameraError for a rate outside 1..10 Hz, a negative latency or an invalid probability.

        detect  how many people a detector finds in the picture of a stamp (ns), in place of the true count;
                None if the picture is bad
        """
        shares = (params.miss, params.ghost, params.dropout)
        if not (1.0 <= params.rate_hz <= 10.0 and params.latency_s >= 0.0):
            raise CameraError(f"the rate must be 1..10 Hz and the latency not negative, not {params}")
        if not all(0.0 <= share <= 1.0 for share in shares):
            raise CameraError(f"miss, ghost and dropout are probabilities from 0 to 1, not {shares}")
        self.area_id = area.area_id
        self._outline = outline_array(area)
        self._params, self._rng, self._detect = params, rng, detect
        self._period_ns = round(1e9 / params.rate_hz)
        self._due_ns: int | None = None
        self._pending: deque[tuple[int, int, int]] = deque()

    def step(self, now_ns: int, people: Array) -> tuple[PresenceReport, ...]:
        """The reports that are due now; people (n, 2): all positions, map frame."""
        if self._due_ns is None:
            self._due_ns = now_ns
        while now_ns >= self._due_ns:
            self._take_picture(self._due_ns, people)
            self._due_ns += self._period_ns
        reports = []
        while self._pending and self._pending[0][0] <= now_ns:
            _, taken_ns, count = self._pending.popleft()
            reports.append(PresenceReport(self.area_id, count, (now_ns - taken_ns) * 1e-9))
        return tuple(reports)

    def _take_picture(self, taken_ns: int, people: Array) -> None:
        params = self._params
        if self._detect is not None:
            self._detect_people(taken_ns, self._detect)
            return
        there = int(np.count_nonzero(inside(self._outline, people))) if len(people) else 0
        # Always the same number of draws, so that a lost report does not change the later ones.
        misses, ghost, lost = self._rng.random(there), self._rng.random(), self._rng.random()
        count = int(np.count_nonzero(misses >= params.miss)) + int(ghost < params.ghost)
        self._report(taken_ns, count, lost)

    def _detect_people(self, taken_ns: int, detect: Callable[[int], int | None]) -> None:
        count, lost = detect(taken_ns), self._rng.random()
        if count is not None:
            self._report(taken_ns, count, lost)

    def _report(self, taken_ns: int, count: int, lost: float) -> None:
        params = self._params
        is_down = any(begin <= taken_ns * 1e-9 < end for begin, end in params.down)
        if lost >= params.dropout and not is_down:
            self._pending.append((taken_ns + round(params.latency_s * 1e9), taken_ns, count))


def cameras_at_crossings(
    road_map: RoadMap,
    params: CameraParams,
    rng: Callable[[str], np.random.Generator],
    detector_of: Callable[[ObservationArea], Callable[[int], int | None]] | None = None,
) -> tuple[CrossingCamera, ...]:
    """One at each crossing of the map.

    rng: a random stream by its purpose; detector_of: gives each camera its `detect`
    """
    return tuple(
        CrossingCamera(
            area, params, rng(f"camera {area.area_id}"), None if detector_of is None else detector_of(area)
        )
        for area in road_map.observation_areas
        if area.kind == "crossing"
    )
