"""The link's mail to the process that records video: operators' marks, as they stand in the run log."""

from collections import deque
from collections.abc import Callable, Iterable

import msgspec

from contract.runlog.records import MARK_TOPIC, RecordingMark
from vehicle_agent.runtime.recording.recorder import LogEntry, RunLogEntry
from vehicle_agent.runtime.video.wanted_spans import VideoMark

# While the process is away, which its supervisor does not let last.
KEPT_MAX = 200


class VideoMarks:
    """Passes marks on; those that do not arrive are sent again with the next report of the tick."""

    def __init__(self, post: Callable[[VideoMark], bool]) -> None:
        """post: False if the mail is lost."""
        self._post = post
        self._kept: deque[VideoMark] = deque(maxlen=KEPT_MAX)

    def pass_on(self, entries: Iterable[RunLogEntry]) -> None:
        for entry in entries:
            if isinstance(entry, LogEntry) and entry.topic == MARK_TOPIC:
                mark = msgspec.json.decode(entry.data, type=RecordingMark)
                self._kept.append(VideoMark(mark.name, mark.at_ns, mark.mark_id))
        while self._kept and self._post(self._kept[0]):
            self._kept.popleft()
