"""The people detector is there, says how it is installed, and finds people where they are."""

import sys
from types import ModuleType

import numpy as np
import pytest

from vehicle_agent.perception.camera.people_detector import CameraLibraryMissing, HogPeopleDetector, opencv


def a_dummy(height_px: int) -> np.ndarray:
    """A dark figure on a bright wall: head, trunk, legs."""
    pixels = np.full((240, 320, 3), 190, np.uint8)
    rng = np.random.default_rng(1)
    pixels = np.clip(pixels + rng.normal(0.0, 2.0, pixels.shape), 0, 255).astype(np.uint8)
    v, u = np.mgrid[:240, :320]
    x, y = (u - 160) / height_px, (200 - v) / height_px
    head = np.hypot(x, y - 0.93) < 0.065
    trunk = (np.abs(x) < 0.13 - 0.15 * np.maximum(0.0, y - 0.80)) & (y > 0.45) & (y < 0.86)
    legs = (np.abs(np.abs(x) - 0.055) < 0.045) & (y >= 0.0) & (y <= 0.47)
    pixels[head | trunk | legs] = (40, 42, 45)
    return pixels


def test_without_opencv_the_message_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(CameraLibraryMissing, match="make camera"):
        HogPeopleDetector()


def test_a_build_without_the_people_detector_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = ModuleType("cv2")
    plain.__version__ = "5.0.0"  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "cv2", plain)
    with pytest.raises(CameraLibraryMissing, match="no HOG people detector"):
        opencv()


def test_the_installed_opencv_has_the_people_detector() -> None:
    cv2 = pytest.importorskip("cv2", reason="the extra `camera` is not installed")
    assert len(cv2.HOGDescriptor_getDefaultPeopleDetector()) == 3781


@pytest.mark.parametrize("height_px", [45, 96, 150])
def test_a_figure_scores_above_a_wall_and_its_feet_are_found(height_px: int) -> None:
    pytest.importorskip("cv2", reason="the extra `camera` is not installed")
    detector = HogPeopleDetector(8, 16)
    pixels = a_dummy(height_px)
    score, feet = detector.best(pixels, (160.0, 200.0), height_px)
    assert score > 0.5
    assert np.hypot(feet[0] - 160.0, feet[1] - 200.0) <= 0.15 * height_px
    assert detector.score(pixels, (60.0, 200.0), height_px) < 0.0
    # The place may be wrong by a tenth of the height.
    assert detector.score(pixels, (160.0, 200.0 + 0.1 * height_px), height_px) > 0.5


def test_regions_beyond_the_picture_score_low_and_do_not_fail() -> None:
    pytest.importorskip("cv2", reason="the extra `camera` is not installed")
    detector = HogPeopleDetector()
    pixels = a_dummy(96)
    for feet in (
        (-500.0, 100.0),
        (900.0, 100.0),
        (160.0, -300.0),
        (160.0, 2000.0),
        (-5.0, 10.0),
        (330.0, 260.0),
    ):
        assert detector.score(pixels, feet, 80.0) < 0.5


def test_an_allowance_between_cells_is_refused() -> None:
    with pytest.raises(ValueError, match="multiples of 8"):
        HogPeopleDetector(5, 8)
