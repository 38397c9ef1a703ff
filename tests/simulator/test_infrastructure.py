"""The camera at a crossing: what it counts, when it says so, and when it does not."""

import numpy as np
import pytest

from contract.roads.model import ObservationArea
from simulator.infrastructure import CameraError, CameraParams, CrossingCamera

AREA = ObservationArea("zebra", "crossing", ((0.0, 0.0), (4.0, 0.0), (4.0, 8.0), (0.0, 8.0)), (("a", 1.0),))
INSIDE, OUTSIDE = np.array([[1.0, 1.0], [2.0, 6.0]]), np.array([[5.0, 1.0], [-1.0, 2.0]])
STEP_NS = 20_000_000
SHARP = CameraParams(miss=0.0, ghost=0.0, dropout=0.0)


def watch(params: CameraParams, people: np.ndarray, seconds: float = 20.0, seed: int = 1):  # type: ignore[no-untyped-def]
    camera = CrossingCamera(AREA, params, np.random.default_rng(seed))
    said = []
    for k in range(round(seconds * 50)):
        said += [(k * STEP_NS, word) for word in camera.step(k * STEP_NS, people)]
    return said


def test_it_counts_who_is_in_its_area() -> None:
    assert {word.count for _, word in watch(SHARP, np.vstack((INSIDE, OUTSIDE)))} == {2}
    assert {word.count for _, word in watch(SHARP, OUTSIDE)} == {0}
    assert {word.count for _, word in watch(SHARP, np.empty((0, 2)))} == {0}


@pytest.mark.parametrize("rate_hz", [1.0, 5.0])
def test_it_speaks_at_its_rate_also_when_nobody_is_there(rate_hz: float) -> None:
    said = watch(CameraParams(rate_hz=rate_hz, miss=0, ghost=0, dropout=0), np.empty((0, 2)))
    assert len(said) == pytest.approx(20.0 * rate_hz, abs=1)


def test_words_come_late_and_say_how_old_they_are() -> None:
    said = watch(SHARP, INSIDE)
    assert said[0][0] == pytest.approx(0.16e9, abs=STEP_NS)
    assert all(word.age_s == pytest.approx(0.15, abs=0.02) for _, word in said)


def test_misses_ghosts_and_losses_are_as_frequent_as_they_were_made() -> None:
    params = CameraParams(rate_hz=10.0, miss=0.2, ghost=0.1, dropout=0.3)
    said = watch(params, INSIDE, 1000.0)
    assert len(said) == pytest.approx(10_000 * 0.7, rel=0.05)
    assert np.mean([word.count for _, word in said]) == pytest.approx(2 * 0.8 + 0.1, rel=0.05)


def test_a_camera_that_is_down_says_nothing() -> None:
    params = CameraParams(miss=0.0, ghost=0.0, dropout=0.0, down=((5.0, 10.0),))
    taken_s = [stamp_ns * 1e-9 - word.age_s for stamp_ns, word in watch(params, INSIDE)]
    assert not any(5.0 <= t < 9.99 for t in taken_s)
    assert max(taken_s) > 15.0


def test_one_seed_gives_the_same_words() -> None:
    assert watch(CameraParams(), INSIDE) == watch(CameraParams(), INSIDE)
    assert watch(CameraParams(), INSIDE, seed=2) != watch(CameraParams(), INSIDE)


@pytest.mark.parametrize(
    "params", [CameraParams(rate_hz=0.1), CameraParams(miss=1.5), CameraParams(latency_s=-1.0)]
)
def test_a_camera_that_cannot_be_is_refused(params: CameraParams) -> None:
    with pytest.raises(CameraError):
        CrossingCamera(AREA, params, np.random.default_rng(1))
