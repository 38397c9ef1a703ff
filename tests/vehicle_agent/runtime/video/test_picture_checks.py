"""A black camera and one that repeats its picture are named; a night with noise is neither."""

import numpy as np

from vehicle_agent.runtime.video.picture_checks import PictureState, Trouble, check

RNG = np.random.default_rng(1)
STREET = RNG.integers(30, 220, (480, 640), dtype=np.uint8)


def troubles(pictures: list[np.ndarray]) -> list[Trouble]:
    state, found = PictureState(), []
    for number, picture in enumerate(pictures):
        state = check(state, number * 100_000_000, picture)
        found.append(state.trouble)
    return found


def with_noise(picture: np.ndarray) -> np.ndarray:
    noisy: np.ndarray = picture + RNG.integers(0, 4, picture.shape, dtype=np.uint8)
    return noisy


def test_a_camera_that_works_has_no_trouble() -> None:
    assert set(troubles([with_noise(STREET) for _ in range(40)])) == {""}


def test_a_frozen_camera_is_named_after_two_seconds_and_no_longer_once_it_moves() -> None:
    found = troubles([STREET] * 30 + [with_noise(STREET)])
    assert (found[19], found[20], found[29], found[30]) == ("", "frozen", "frozen", "")


def test_a_black_camera_is_named_also_with_noise() -> None:
    black = np.full((480, 640), 16, np.uint8)
    found = troubles([with_noise(black) for _ in range(25)] + [with_noise(STREET)])
    assert (found[19], found[20], found[24], found[25]) == ("", "black", "black", "")


def test_a_night_with_lamps_is_not_black() -> None:
    night = np.full((480, 640), 16, np.uint8)
    night[100:160, 80:400] = 200
    assert set(troubles([with_noise(night) for _ in range(40)])) == {""}
