"""A camera that shows nothing true is noticed, whatever it shows."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.perception.camera.conditions import CameraCondition, CameraRules
from vehicle_agent.signals.pictures import Picture

RULES = CameraRules()
PERIOD_NS = 100_000_000


def a_view(seed: int) -> np.ndarray:
    """A scene with a sensor's noise: bright above, dark below."""
    rng = np.random.default_rng(seed)
    level = np.linspace(180.0, 60.0, 96)[:, None, None]
    return np.clip(level + rng.normal(0.0, 6.0, (96, 128, 3)), 0.0, 255.0).astype(np.uint8)


def after(pictures: list[np.ndarray]) -> CameraCondition:
    condition = CameraCondition("front")
    for number, pixels in enumerate(pictures):
        condition = RULES.after_picture(condition, Picture("front", number * PERIOD_NS, pixels))
    return condition


@given(st.integers(0, 1000), st.integers(1, 12))
@settings(max_examples=15, deadline=None)
def test_pictures_of_a_scene_are_good(seed: int, count: int) -> None:
    assert after([a_view(seed + k) for k in range(count)]).state == "good"


@pytest.mark.parametrize(
    ("pixels", "state"),
    [
        (np.zeros((96, 128, 3), np.uint8), "black"),
        (np.full((96, 128, 3), 90, np.uint8), "covered"),
        (np.full((96, 128, 3), 255, np.uint8), "dazzled"),
    ],
)
def test_a_picture_that_shows_nothing_is_named(pixels: np.ndarray, state: str) -> None:
    condition = after([a_view(1), pixels])
    assert condition.state == state
    assert condition.since_ns == PERIOD_NS
    assert RULES.after_picture(condition, Picture("front", 2 * PERIOD_NS, a_view(2))).state == "good"


def test_the_same_picture_again_and_again_is_frozen_and_a_new_one_is_not() -> None:
    assert after([a_view(1)] * RULES.same_max).state == "good"
    frozen = after([a_view(1)] * (RULES.same_max + 1))
    assert frozen.state == "frozen"
    assert RULES.after_picture(frozen, Picture("front", 10**10, a_view(2))).state == "good"


def test_a_camera_is_silent_before_its_first_picture_and_after_its_last() -> None:
    assert CameraCondition("front").state == "silent"
    good = after([a_view(1)])
    assert RULES.at(good, RULES.silent_ns).state == "good"
    assert RULES.at(good, RULES.silent_ns + 1).state == "silent"


def test_people_who_stand_on_their_heads_are_an_upside_down_camera() -> None:
    condition = after([a_view(1)])
    for _ in range(4):
        condition = RULES.after_regions(condition, 0, 1)
    assert condition.state == "upside_down"
    for _ in range(3):
        condition = RULES.after_regions(condition, 1, 0)
    assert condition.state == "good"


def test_an_old_picture_changes_nothing() -> None:
    condition = after([a_view(1), a_view(2)])
    assert RULES.after_picture(condition, Picture("front", 0, np.zeros((96, 128, 3), np.uint8))) is condition
