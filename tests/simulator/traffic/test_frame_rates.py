import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.traffic.frame_rates import CAMERA_FPS, FrameRateError, frame_rate_fps


def a_walk(fps: float, speed_mps: float = 1.3, heading: float = 0.4, frames: int = 60) -> np.ndarray:
    """(frames, 5) frame, x, y, vx, vy of a person with a constant velocity."""
    velocity = speed_mps * np.array((np.cos(heading), np.sin(heading)))
    frame = np.arange(1.0, frames + 1)
    places = frame[:, None] / fps * velocity
    return np.column_stack((frame, places, np.tile(velocity, (frames, 1))))


@given(
    fps=st.sampled_from(CAMERA_FPS),
    heading=st.floats(-3.1, 3.1),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_cameras_rate_is_read_from_noisy_positions(fps: float, heading: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    tracks = [a_walk(fps, speed, heading + speed) for speed in (0.9, 1.2, 1.3, 1.5)]
    for track in tracks:
        track[:, 1:3] += rng.normal(0.0, 0.005, (len(track), 2))
    assert frame_rate_fps(tracks, []) == fps


@given(fps=st.floats(8.0, 20.0))
def test_a_rate_of_no_known_camera_is_kept_as_measured(fps: float) -> None:
    assert frame_rate_fps([a_walk(fps)], []) == pytest.approx(fps, rel=1e-9)


def test_a_recording_of_every_tenth_frame_has_the_cameras_rate() -> None:
    walk = a_walk(25.0, frames=400)[::10]
    assert frame_rate_fps([walk], []) == 25.0


def test_cars_give_the_rate_where_no_person_walks() -> None:
    standing = a_walk(25.0, speed_mps=0.0)
    assert frame_rate_fps([standing], [a_walk(50.0, speed_mps=4.0)]) == 50.0


def test_without_motion_the_rate_cannot_be_read() -> None:
    with pytest.raises(FrameRateError, match="nothing in it moves"):
        frame_rate_fps([a_walk(25.0, speed_mps=0.0)], [])


def test_positions_in_pixels_are_refused() -> None:
    walk = a_walk(25.0)
    walk[:, 1:3] *= 40.0
    with pytest.raises(FrameRateError, match="must be in metres"):
        frame_rate_fps([walk], [])
