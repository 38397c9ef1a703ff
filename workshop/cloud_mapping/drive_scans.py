"""The scans of one drive from its recordings; what is damaged is left out, and said."""

from collections.abc import Iterator, Sequence

from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.errors import CloudFileError
from workshop.clouds.recordings import Recording

# More damaged files than this are not worth a sentence each.
_NOTES_MAX = 5


class DriveScans:
    """The scans of recordings, one after the other. notes: a sentence for what could not be read."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        self._recordings = recordings
        self.notes: list[str] = []
        self.damaged = 0

    def __len__(self) -> int:
        """Scans or messages, as many as are expected."""
        return sum(len(recording) for recording in self._recordings)

    def __iter__(self) -> Iterator[PointCloud]:
        for recording in self._recordings:
            # A file is read alone, so that one that is damaged does not end the drive. A bag ends where it
            # is cut.
            parts = [Recording(recording.path, (file,)) for file in recording.files] or [recording]
            is_alone = len(parts) == 1
            for number, part in enumerate(parts):
                try:
                    for cloud in part.scans():
                        yield cloud if is_alone else _stamped(cloud, recording, number)
                except CloudFileError as error:
                    self.damaged += 1
                    if len(self.notes) < _NOTES_MAX:
                        self.notes.append(f"left out: {error}")
        if self.damaged > _NOTES_MAX:
            self.notes.append(f"left out: {self.damaged - _NOTES_MAX} more files")


def _stamped(cloud: PointCloud, recording: Recording, number: int) -> PointCloud:
    stamp_ns = recording.stamp_ns(number)
    return PointCloud(stamp_ns, cloud.points_sensor, cloud.intensities, cloud.rings, cloud.offsets_ns)
