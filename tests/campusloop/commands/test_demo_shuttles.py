"""Which shuttles the live demo drives: ones that see for themselves, as many as the machine carries."""

import pytest
from rich.console import Console
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.commands import demo
from campusloop.live.campus import LiveOptions
from vehicle_agent.config import load_profile


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, tmp_path: object) -> list[LiveOptions]:
    """The options of demos that would have started."""
    options: list[LiveOptions] = []

    class NoDemo:
        def __init__(self, given: LiveOptions, console: Console, *, people_book: bool) -> None:
            options.append(given)

        async def run(self) -> None: ...

    monkeypatch.chdir(str(tmp_path))
    monkeypatch.setattr(demo, "LiveDemo", NoDemo)
    monkeypatch.setattr(demo, "prepare_kernels", lambda kernels, console: None)
    monkeypatch.setattr(demo, "scan_cpu_s", lambda profile: 0.04)
    monkeypatch.setattr(demo, "cores", lambda: 2)
    return options


def run(*arguments: str) -> str:
    done = CliRunner().invoke(app_of(), ["demo", *arguments])
    assert done.exit_code == 0, done.output
    return done.output


def test_without_options_shuttles_find_road_users_by_themselves(started: list[LiveOptions]) -> None:
    output = run()
    (options,) = started
    assert options.profile_path is not None
    profile = load_profile(options.profile_path)
    assert (profile.stack, profile.perception) == ("snow_lion", "own")
    assert options.scene is not None
    assert options.vehicles == 1
    assert "1 shuttle finds road users" in output
    assert "about 0.9 of real time" in output


def test_who_wants_more_than_the_machine_carries_is_told_how_slow_it_will_be(
    started: list[LiveOptions],
) -> None:
    output = run("--vehicles", "3")
    assert started[0].vehicles == 3
    assert "about 0.3 of real time" in output


def test_a_fast_machine_has_three(started: list[LiveOptions], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo, "cores", lambda: 16)
    monkeypatch.setattr(demo, "scan_cpu_s", lambda profile: 0.005)
    run()
    assert started[0].vehicles == 3


def test_with_a_tracker_they_are_told_of_road_users(started: list[LiveOptions]) -> None:
    run("--perception", "tracker")
    (options,) = started
    assert options.scene is None
    assert options.profile_path is None
    assert options.vehicles == 2
