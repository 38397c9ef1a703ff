"""The recorded drives of a folder, split into those that the model was fitted on and the others."""

import json
from dataclasses import dataclass
from pathlib import Path

from campusloop.scenes.recorded.drives import recorded_drives
from simulator.traffic.recordings import Clip, RecordedTrack, drone_clips

_SPLIT = Path(__file__).with_name("split.json")


@dataclass(frozen=True, slots=True)
class Drive:
    """One recorded drive; is_fitted: the model's parameters come from it among others."""

    clip: Clip
    car: RecordedTrack
    is_fitted: bool


def drives_of(folder: Path) -> list[Drive]:
    """All drives of the folder. RecordingError without any recording."""
    fitted = fitted_recordings()
    return [
        Drive(clip, drive.car, clip.name in fitted)
        for clip in drone_clips(folder)
        for car in clip.cars()
        for drive in recorded_drives(car)
    ]


def fitted_recordings() -> frozenset[str]:
    """The names of the recordings that parameters may be tuned on; all others are held out."""
    return frozenset(json.loads(_SPLIT.read_text(encoding="utf-8"))["fit"])


def outline(car: RecordedTrack) -> tuple[float, float, float]:
    """Rear, front and half width of the car around its middle."""
    return 0.5 * car.size_m[0], 0.5 * car.size_m[0], 0.5 * car.size_m[1]
