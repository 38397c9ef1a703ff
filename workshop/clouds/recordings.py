"""Sequences of scans: folders of numbered files, and bags; and the poses that lie beside them."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from vehicle_agent.lidar.models import LidarModel
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds import bags
from workshop.clouds.errors import CloudFileError
from workshop.clouds.kitti_bin import read_kitti_bin
from workshop.clouds.pcd import read_pcd
from workshop.clouds.ply import read_ply

READERS: dict[str, Callable[[Path, int | None], PointCloud]] = {
    ".pcd": read_pcd,
    ".ply": read_ply,
    ".bin": read_kitti_bin,
}
# Files have no time of their own unless their name is one: what most lidars turn at.
_PERIOD_NS = 100_000_000
# A name of so many digits is a time in ns.
_STAMP_DIGITS = 16


def read_cloud(path: Path, stamp_ns: int | None = None) -> PointCloud:
    """One file of points, by its suffix; CloudFileError."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise CloudFileError(path, f"is none of {', '.join(READERS)}")
    return reader(path, stamp_ns)


@dataclass(frozen=True, slots=True)
class Recording:
    """One sequence: a folder of numbered files, or one topic of a bag.

    path   the folder or bag
    files  the files in order; empty for a bag
    topic  of a bag
    """

    path: Path
    files: tuple[Path, ...] = ()
    topic: bags.Topic | None = None

    def __len__(self) -> int:
        """Scans, or messages of a bag's topic: a message of packets may hold less than a scan."""
        return len(self.files) if self.topic is None else self.topic.messages

    def scans(self, model: LidarModel | None = None) -> Iterator[PointCloud]:
        """The scans in order; CloudFileError for one that cannot be read."""
        if self.topic is not None:
            yield from bags.scans(self.path, self.topic, model)
            return
        for number, file in enumerate(self.files):
            yield read_cloud(file, self.stamp_ns(number))

    def stamp_ns(self, number: int) -> int:
        """Of a file: its name if that is a time, otherwise its place in the folder."""
        digits = "".join(re.findall(r"\d+", self.files[number].stem))
        return int(digits) if len(digits) >= _STAMP_DIGITS else number * _PERIOD_NS


def find_recordings(path: Path) -> list[Recording]:
    """The sequences of a file or folder and all folders below it, by path; CloudFileError if there are none.

    A folder with two or more numbered files of one suffix is a sequence. Of a bag it is the topic with most
    scans; a bag without scans is left out.
    """
    if not path.exists():
        raise CloudFileError(path, "does not exist")
    found = _found(path)
    if not found:
        raise CloudFileError(path, f"no bag, and no folder of numbered files ({', '.join(READERS)})")
    return found


def _found(path: Path) -> list[Recording]:
    if bags.is_bag(path):
        try:
            return [Recording(path, topic=bags.topic_with_scans(path))]
        except CloudFileError:
            # Beside lidar there are bags of other sensors. What is asked for by name has to be readable.
            if path.is_dir() or any(topic.has_scans for topic in bags.topics(path)):
                raise
            return []
    if not path.is_dir():
        return [Recording(path.parent, files=(path,))] if path.suffix.lower() in READERS else []
    found: list[Recording] = []
    inside = sorted(path.iterdir())
    for suffix in READERS:
        numbered = [f for f in inside if f.suffix.lower() == suffix and re.search(r"\d", f.stem)]
        files = sorted(numbered, key=_order)
        if len(files) > 1:
            found.append(Recording(path, files=tuple(files)))
    for child in inside:
        if child.is_dir() or bags.is_bag(child):
            found += _found(child)
    return found


def _order(file: Path) -> tuple[list[int], str]:
    """Files by the numbers in their names, so that 10 comes after 9."""
    return [int(number) for number in re.findall(r"\d+", file.stem)], file.name
