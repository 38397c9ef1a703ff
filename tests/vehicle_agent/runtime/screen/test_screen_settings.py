"""screen.toml: refused at the start with what to do."""

from pathlib import Path

import pytest

from vehicle_agent.runtime.screen.screen_settings import ScreenError, load_screen_settings


@pytest.fixture
def pages(tmp_path: Path) -> Path:
    folder = tmp_path / "dist"
    folder.mkdir()
    (folder / "onboard.html").write_text("<!doctype html>")
    return folder


def settings(tmp_path: Path, pages: Path, more: str = "") -> Path:
    path = tmp_path / "screen.toml"
    path.write_text(f'pages = "{pages}"\n{more}')
    return path


def test_without_the_file_no_screen_is_served(tmp_path: Path) -> None:
    assert load_screen_settings(tmp_path / "screen.toml") is None


def test_by_default_this_computer_alone_may_use_it(tmp_path: Path, pages: Path) -> None:
    found = load_screen_settings(settings(tmp_path, pages))
    assert found is not None
    assert found.address() == ("127.0.0.1", 47_700)
    assert [str(network) for network in found.allowed()] == ["127.0.0.0/8", "::1/128"]


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ('networks = ["8.8.8.0/24"]', "not private"),
        ('networks = ["0.0.0.0/0"]', "not private"),
        ('networks = ["10.0.0.1/24"]', "host bits"),
        ('listen = "10.0.0.2"', "HOST:PORT"),
        ('listen = "10.0.0.2:99999"', "HOST:PORT"),
        ("port = 3", "unknown field"),
    ],
)
def test_settings_that_cannot_be_meant_are_refused(tmp_path: Path, pages: Path, more: str, says: str) -> None:
    with pytest.raises(ScreenError, match=says):
        load_screen_settings(settings(tmp_path, pages, more))


def test_missing_pages_are_named(tmp_path: Path) -> None:
    with pytest.raises(ScreenError, match="make web"):
        load_screen_settings(settings(tmp_path, tmp_path / "nowhere"))
