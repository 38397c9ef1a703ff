"""A crossing's camera at work: pictures, counts, reports, and what is said when the video fails."""

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from campusloop.crossing_cameras.people_counter import PeopleCounter
from campusloop.crossing_cameras.video import Video, VideoFailure
from contract.wire.messages import PresenceReport
from vehicle_agent.perception.camera.conditions import CameraCondition, CameraRules
from vehicle_agent.signals.pictures import Picture

_REOPEN_S = (1.0, 2.0, 5.0, 10.0)
# A report may not be older (`PresenceReport.age_s`).
_AGE_S_MAX = 10.0


@dataclass(frozen=True, slots=True)
class WatchOptions:
    """rate_hz  reports per second; once: the watch ends with the video, or with the first failure"""

    area_id: str
    rate_hz: float = 5.0
    once: bool = False


class CrossingWatch:
    """Watches one area. A source that fails is told, and opened again; a bad picture gives no report."""

    def __init__(
        self,
        source: str,
        counter: Callable[[], PeopleCounter],
        options: WatchOptions,
        put: Callable[[PresenceReport], None],
        tell: Callable[[str], None],
    ) -> None:
        """counter: makes the counter of one connection; its background is that of one camera's view."""
        self._source, self._counter, self._options = source, counter, options
        self._put, self._tell = put, tell
        self.reports = 0

    async def run(self) -> None:
        """Until cancelled. With `once`, raises VideoFailure when the video ends or fails."""
        failures = 0
        while True:
            before = self.reports
            try:
                await self._play()
            except VideoFailure as failure:
                if self._options.once:
                    raise
                failures = 0 if self.reports > before else failures + 1
                wait_s = _REOPEN_S[min(failures, len(_REOPEN_S) - 1)]
                self._tell(f"{failure}; it is opened again in {wait_s:g} s")
                await asyncio.sleep(wait_s)

    async def _play(self) -> None:
        """Reports until the source fails. Pictures are read in a thread, for a stream may hang."""
        video = await asyncio.to_thread(Video, self._source)
        condition, counter = CameraCondition(self._options.area_id), self._counter()
        period_s = 1.0 / self._options.rate_hz
        begun_s, number = time.monotonic(), 0
        try:
            while True:
                pixels, taken_s = await asyncio.to_thread(_next_picture, video, begun_s, number, period_s)
                number += 1
                condition = self._judged(condition, pixels, taken_s)
                count = await asyncio.to_thread(counter.count, pixels)
                age_s = time.monotonic() - taken_s
                if condition.state == "good" and age_s <= _AGE_S_MAX:
                    self.reports += 1
                    self._put(PresenceReport(self._options.area_id, min(count, 1000), age_s))
        finally:
            video.close()

    def _judged(self, before: CameraCondition, pixels: np.ndarray, taken_s: float) -> CameraCondition:
        picture = Picture(before.camera, max(before.stamp_ns + 1, round(taken_s * 1e9)), pixels)
        after = CameraRules().after_picture(before, picture)
        if after.state != before.state:
            no_reports = "" if after.state == "good" else ": no reports until it is good again"
            self._tell(f"the picture of {self._source} is {after.state}{no_reports}")
        return after


def _next_picture(video: Video, begun_s: float, number: int, period_s: float) -> tuple[np.ndarray, float]:
    """The picture of the period `number` and when it was taken. A file is played at its own speed."""
    due_s = begun_s + number * period_s
    if video.is_file:
        first = round(number * period_s * video.rate_hz)
        for _ in range(first - video.pictures_read):
            video.skip()
        time.sleep(max(0.0, due_s - time.monotonic()))
        return video.picture(), time.monotonic()
    # A stream is read as it comes, so that its buffer never holds old pictures.
    while time.monotonic() < due_s:
        video.skip()
    return video.picture(), time.monotonic()
