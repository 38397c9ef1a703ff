"""Scenarios driven by the whole onboard loop: they can pass and fail, and repeat bit for bit."""

from pathlib import Path

import msgspec
import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.scenes.faults import Camera, InputFault
from campusloop.scenes.scenario_files.road_users import Cue, Follower, Group, OtherShuttle, Person, Queue
from campusloop.scenes.scenario_files.scenario import Outcome, drive
from campusloop.scenes.scenario_files.scenario_file import (
    Expectations,
    Operator,
    Road,
    ScenarioError,
    ScenarioFile,
    Shuttle,
)
from vehicle_agent.config import Profile
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

ROAD = Road(path=((0.0, 0.0), (46.0, 0.0)))
WALKER = Person(at=(28.0, 4.0), heading_deg=-90.0, way=((28.0, -4.0),), when=Cue(distance_m=14.0))
EASY = ScenarioFile(title="t", road=ROAD, shuttle=Shuttle(goal_s_m=24.0), max_time_s=20.0)


def driven(found: ScenarioFile, runs: Path | None = None) -> Outcome:
    return drive(found, "test", Profile(), Path(), runs)


def test_expectations_that_hold_and_that_do_not() -> None:
    hard = Expectations(
        reaches_goal=False, time_s_max=3.0, stops_before_s_m=20.0, never_passes_s_m=10.0, stands_s_min=5.0,
        decel_mps2_max=0.001, says=("minimal_risk",), never_says=("waypoint_speed",),
    )  # fmt: skip
    good = driven(
        msgspec.structs.replace(EASY, expect=Expectations(reaches_goal=True, never_says=("fault",)))
    )
    assert good.failures == ()
    bad = driven(msgspec.structs.replace(EASY, expect=hard))
    assert len(bad.failures) == 7 + (bad.run.trace.array()[:, 5].min() < 0)
    assert bad.run.trace.rows == good.run.trace.rows


def test_a_recorded_scenario_replays_bit_for_bit(tmp_path: Path) -> None:
    found = msgspec.structs.replace(EASY, person=(WALKER,), expect=Expectations(reaches_goal=True))
    driven(found, tmp_path / "runs")
    (segment,) = sorted((tmp_path / "runs").rglob("*.mcap"))
    result = replay_segment(segment, build_car)
    assert result.difference is None
    assert result.ticks > 300


def test_a_position_that_is_not_a_number_ends_in_a_stop_until_an_operator_resumes() -> None:
    fault = InputFault("pose_nan", 4.0, 5.0)
    found = msgspec.structs.replace(EASY, fault=(fault,), max_time_s=40.0)
    stopped = driven(
        msgspec.structs.replace(found, expect=Expectations(reaches_goal=False, says=("minimal_risk",)))
    )
    assert stopped.failures == ()
    resumed = msgspec.structs.replace(
        found, operator=Operator((10.0,)), expect=Expectations(reaches_goal=True, says=("minimal_risk",))
    )
    assert driven(resumed).failures == ()


def test_a_camera_needs_an_area_to_watch() -> None:
    with pytest.raises(ScenarioError, match="no observation area 'x'"):
        driven(msgspec.structs.replace(EASY, camera=(Camera("x"),)))


def test_the_command_says_what_failed_and_exits_so(tmp_path: Path) -> None:
    file = tmp_path / "short.toml"
    file.write_text(
        'title = "t"\nmax_time_s = 3.0\n[road]\npath = [[0, 0], [60, 0]]\n[expect]\nreaches_goal = true\n'
    )
    app, out = app_of(("scenario",)), tmp_path / "out"
    first = CliRunner().invoke(app, ["scenario", "run", str(file), "--stack", "gem", "--out", str(out)])
    assert first.exit_code == 1
    assert "short: drove only" in first.output
    assert (out / "gem" / "short" / "short.csv").exists()
    again = CliRunner().invoke(app, ["scenario", "run", str(file), "--stack", "gem", "--out", str(out)])
    assert again.exit_code == 2
    unknown = CliRunner().invoke(app, ["scenario", "run", str(file), "--stack", "ghost"])
    assert unknown.exit_code == 2
    assert "ghost" in unknown.output


def test_two_shuttles_of_one_stack_pass_each_other_and_see_each_other() -> None:
    found = ScenarioFile(
        title="t",
        road=Road(path=((0.0, -2.2), (50.0, -2.2)), width_m=4.4),
        other_shuttle=(OtherShuttle(path=((50.0, 2.2), (0.0, 2.2)), width_m=4.4),),
        max_time_s=40.0,
        expect=Expectations(reaches_goal=True, others_arrive=True, clearance_m_min=2.0),
    )
    outcome = driven(found)
    (other,) = outcome.run.others
    assert outcome.run.time_s is not None
    assert not other.metrics.front_contacts
    assert 2.0 < outcome.run.metrics.clearance_m < 3.5
    assert len(outcome.run.trace.agents[0].numbers) == 1
    assert outcome.failures == ()


def test_a_shuttle_that_sets_off_too_early_is_told() -> None:
    bad = driven(msgspec.structs.replace(EASY, expect=Expectations(stands_until_s=15.0)))
    assert "before 15 s" in bad.failures[0]


def test_a_group_stops_the_shuttle_and_a_follower_does_not() -> None:
    group = Group(at=(30.0, 0.0), count=4)
    follower = Follower(at=(8.0, 4.0), place=(-2.5, 0.0), speed_mps=3.0)
    queue = Queue(at=(40.0, -3.0), count=5, heading_deg=180.0)
    stops = Expectations(reaches_goal=False, never_passes_s_m=27.0)
    road = msgspec.structs.replace(EASY, shuttle=Shuttle(goal_s_m=38.0))
    assert driven(msgspec.structs.replace(road, group=(group,), expect=stops)).failures == ()
    followed = msgspec.structs.replace(
        EASY, follower=(follower,), queue=(queue,), expect=Expectations(reaches_goal=True)
    )
    outcome = driven(followed)
    assert outcome.failures == ()
    assert len(outcome.run.trace.agents[0].numbers) == 6


def test_a_plant_seed_gives_another_drive_of_the_same_scene() -> None:
    nominal = driven(EASY)
    drawn = drive(EASY, "test", Profile(), Path(), None, plant_seed=3)
    again = drive(EASY, "test", Profile(), Path(), None, plant_seed=3)
    assert drawn.run.trace.rows == again.run.trace.rows
    assert drawn.run.trace.rows != nominal.run.trace.rows
