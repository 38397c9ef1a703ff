"""The frame rate of a drone recording, read from its own speeds.

The files count frames and do not name the rate. They hold positions and estimated velocities per frame, so
the rate is the factor between the sum of velocities over some frames and the displacement over them. The
people's velocities are used, because the estimates for cars lag by seconds.
"""

from collections.abc import Sequence

import numpy as np

from contract.geometry import Array

# Frame rates of cameras, of which the nearest is taken if it is near enough.
CAMERA_FPS = (24.0 / 1.001, 25.0, 30.0 / 1.001, 50.0, 60.0 / 1.001)
_CAMERA_TOLERANCE = 0.04
FPS_MIN, FPS_MAX = 2.0, 130.0
# One window: long enough that the noise of positions is small against the way.
_WINDOW = 24
_WINDOW_MIN = 6
_MOVING_MPS = 0.4
_MOVED_M_MIN = 0.05


class FrameRateError(ValueError):
    """The frame rate cannot be read; the message says why."""


def frame_rate_fps(people: Sequence[Array], cars: Sequence[Array]) -> float:
    """Frames per second of the recording in which these tracks were filmed.

    people, cars  one (n, 5) array for each track: frame, x, y, vx, vy; frames rise
    Returns       the median over windows of people who walk; over cars if no person walks. It is the rate of
                  a camera in `CAMERA_FPS` if one is within 4 %, else as measured.
    FrameRateError if nothing moves, or if speeds and positions cannot belong together.
    """
    ratios = _ratios_fps(people)
    if not len(ratios):
        ratios = _ratios_fps(cars)
    if not len(ratios):
        raise FrameRateError("nothing in it moves for long enough to read the frame rate")
    measured_fps = float(np.median(ratios))
    if not FPS_MIN <= measured_fps <= FPS_MAX:
        raise FrameRateError(
            f"its speeds and positions belong to {measured_fps:.3g} frames a second; "
            "positions must be in metres and speeds in m/s"
        )
    nearest_fps = min(CAMERA_FPS, key=lambda fps: abs(fps - measured_fps))
    return nearest_fps if abs(nearest_fps / measured_fps - 1.0) < _CAMERA_TOLERANCE else measured_fps


def _ratios_fps(tracks: Sequence[Array]) -> Array:
    """One estimate for each window of each track in which it moves and no frame is missing."""
    ratios = []
    for track in tracks:
        length = min(_WINDOW, len(track) - 1)
        if length < _WINDOW_MIN:
            continue
        steps = np.diff(track[:, 0])
        widest = 3.0 * float(np.median(steps))
        for begin in range(0, len(track) - length, max(1, length // 2)):
            window, frames = track[begin : begin + length + 1], steps[begin : begin + length]
            if frames.max() > widest:
                continue
            means = 0.5 * (window[1:, 3:5] + window[:-1, 3:5])
            swept = (means * frames[:, None]).sum(axis=0)
            moved = window[-1, 1:3] - window[0, 1:3]
            if np.hypot(*swept) < _MOVING_MPS * frames.sum() or np.hypot(*moved) < _MOVED_M_MIN:
                continue
            ratios.append(float(swept @ moved / (moved @ moved)))
    return np.array(ratios)
