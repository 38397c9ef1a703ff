"""What perception asks of the next picture, as a camera's driver reads it."""

from pathlib import Path

import numpy as np
import pytest

from vehicle_agent.picture_windows import WINDOWS_MAX, PictureWindows, picture_windows_path


@pytest.fixture
def asking(tmp_path: Path) -> PictureWindows:
    return PictureWindows(tmp_path / "asked", create=True)


@pytest.fixture
def driver(asking: PictureWindows, tmp_path: Path) -> PictureWindows:
    return PictureWindows(tmp_path / "asked", create=False)


def test_the_driver_reads_what_is_asked_for(asking: PictureWindows, driver: PictureWindows) -> None:
    assert driver.asked() is None, "no picture is needed yet"
    wanted = np.array([[10, 20, 74, 148], [-5, 0, 30, 60]])
    asking.ask(wanted)
    np.testing.assert_array_equal(driver.asked(), wanted)
    asking.ask(np.empty((0, 4), np.int64))
    empty = driver.asked()
    assert empty is not None
    assert empty.shape == (0, 4), "any picture will do"
    asking.ask(None)
    assert driver.asked() is None


def test_of_too_many_windows_the_first_are_asked_for(asking: PictureWindows, driver: PictureWindows) -> None:
    wanted = np.arange(4 * (WINDOWS_MAX + 7)).reshape(-1, 4)
    asking.ask(wanted)
    np.testing.assert_array_equal(driver.asked(), wanted[:WINDOWS_MAX])


def test_a_worker_that_starts_again_asks_in_the_same_file(
    asking: PictureWindows, driver: PictureWindows, tmp_path: Path
) -> None:
    asking.ask(np.array([[1, 2, 3, 4]]))
    again = PictureWindows(tmp_path / "asked", create=True)
    assert driver.asked() is None
    again.ask(np.array([[5, 6, 7, 8]]))
    np.testing.assert_array_equal(driver.asked(), [[5, 6, 7, 8]])


def test_a_file_that_is_being_written_is_not_read(asking: PictureWindows, driver: PictureWindows) -> None:
    asking.ask(np.array([[1, 2, 3, 4]]))
    asking._map[0] |= 1
    assert driver.asked() is None


def test_a_driver_without_a_worker_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        PictureWindows(tmp_path / "asked", create=False)
    (tmp_path / "asked").touch()
    with pytest.raises(OSError, match="not whole"):
        PictureWindows(tmp_path / "asked", create=False)


def test_the_file_lies_beside_the_ring_of_the_lidar(tmp_path: Path) -> None:
    assert picture_windows_path(tmp_path / "s1.scans", "people") == tmp_path / "s1.scans-people.windows"
