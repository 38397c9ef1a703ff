"""A folder of labeled scans, made once and read in every epoch."""

from collections.abc import Callable
from pathlib import Path

from campusloop.scenes.detector_scenes.campuses import CAMPUSES, CampusScene, Split
from campusloop.scenes.detector_scenes.recording import SceneRecorder
from workshop.detector.labeled_scans import write_scan

_SPLIT_NUMBER: dict[Split, int] = {"train": 0, "tune": 1, "held-out": 2}


def make_scans(
    folder: Path, split: Split, seed: int, count: int, advance: Callable[[int], None]
) -> list[Path]:
    """The split's scans, about as many of each campus; those that are there already are kept.

    Raises SceneError, MapError, OSError. A scan is written under another name first, so none is incomplete.
    """
    folder.mkdir(parents=True, exist_ok=True)
    campuses = CAMPUSES[split]
    paths = [folder / f"{split}-{seed}-{number:05d}.npz" for number in range(count)]
    for index, campus in enumerate(campuses):
        missing = [n for n in range(index, count, len(campuses)) if not paths[n].exists()]
        advance(len(range(index, count, len(campuses))) - len(missing))
        if not missing:
            continue
        recorder = SceneRecorder(CampusScene(campus), varied=split == "train")
        for number in missing:
            part = paths[number].with_suffix(".part")
            write_scan(part, recorder.record((seed, _SPLIT_NUMBER[split], number)))
            part.replace(paths[number])
            advance(1)
    return paths
