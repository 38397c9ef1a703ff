"""Scenario files: what is wrong with one is said with file and field."""

import re
from pathlib import Path

import pytest

from campusloop.commands.scenario import scenario_paths
from campusloop.scenes.scenario_files.scenario import scene_of
from campusloop.scenes.scenario_files.scenario_file import ScenarioError, load_scenario
from vehicle_agent.config import Profile

SHIPPED = Path(__file__).resolve().parents[3] / "scenarios"
GOOD = 'title = "t"\n[road]\npath = [[0, 0], [60, 0]]\n'


def written(folder: Path, text: str) -> Path:
    path = folder / "s.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("path", sorted(SHIPPED.rglob("*.toml")), ids=lambda path: path.stem)
def test_every_shipped_file_is_a_scene(path: Path) -> None:
    found = load_scenario(path)
    scene = scene_of(found, path.stem, Profile(), path.parent)
    assert scene.goal_s_m > scene.start_s_m
    assert scene.limit_s == found.max_time_s


@pytest.mark.parametrize(
    ("text", "field", "told"),
    [
        ("title = 3\n", "$.title", "Expected `str`"),
        ('title = "t"\n', "road", "missing required field"),
        ('title = "t"\n[road]\nwidth_m = 3.0\n', "$.road", "either `path`, or `map`"),
        ('title = "t"\n[road]\npath = [[0, 0]]\n', "$.road.path", "two places"),
        ('title = "t"\n[road]\npath = [[0, 0], [nan, 1]]\n', "$.road.path", "not finite"),
        (GOOD + "[shuttle]\ngoal_s_m = 2.0\n", "$.shuttle.goal_s_m", "beyond start_s_m"),
        (GOOD + "[[person]]\nat = [1.0]\n", "$.person[0].at", "length 2"),
        (GOOD + "[[person]]\nat = [1, 2]\nspeed_mps = -1.0\n", "$.person[0].speed_mps", "> 0.0"),
        (GOOD + "[[person]]\nat = [1, 2]\ncolour = 3\n", "$.person[0]", "unknown field `colour`"),
        (GOOD + '[[fault]]\nkind = "gremlin"\n', "$.fault[0].kind", "gremlin"),
        (GOOD + '[[fault]]\nkind = "pose_nan"\nfrom_s = 3.0\nto_s = 2.0\n', "$.fault[0].to_s", "later"),
        (GOOD + '[[camera]]\narea = "x"\nrate_hz = 0.0\n', "$.camera[0].rate_hz", "more than 0"),
        (
            GOOD + "[[person]]\nat = [1, 2]\ncyclist = true\nscooter = true\n",
            "$.person[0].scooter",
            "not both",
        ),
        (
            GOOD + "[[person]]\nat = [1, 2]\nway = [[3, 4]]\nhalts_at = 1\n",
            "$.person[0].halts_at",
            "1 places",
        ),
        (GOOD + "[[group]]\nat = [1, 2]\ncount = 1\n", "$.group[0].count", ">= 2"),
        (GOOD + "[[queue]]\nat = [1, 2]\ncount = 3\nboards_at = [nan, 0]\n", "$.queue[0]", "not finite"),
        (GOOD + "[[door]]\nat = [1, 2]\npeople = 5\ngoals = []\n", "$.door[0].goals", "one place"),
        (
            GOOD + "[[door]]\nat = [1, 2]\npeople = 5\ngoals = [[1, 1]]\npeople_per_s = 0.0\n",
            "$.door[0].people_per_s",
            "> 0.0",
        ),
        (GOOD + "[[follower]]\nat = [1, 2]\n", "$.follower[0]", "missing required field `place`"),
        (GOOD + "[[other_shuttle]]\npath = [[0, 0]]\n", "$.other_shuttle[0].path", "two places"),
        (GOOD + "[expect]\nothers_arrive = true\n", "$.expect.others_arrive", "no `[[other_shuttle]]`"),
        ("title = \n", "s.toml", "value"),
    ],
)
def test_a_bad_file_is_refused_with_file_and_field(tmp_path: Path, text: str, field: str, told: str) -> None:
    with pytest.raises(ScenarioError, match=re.escape(told)) as refused:
        load_scenario(written(tmp_path, text))
    assert field in str(refused.value)
    assert "s.toml" in str(refused.value)


@pytest.mark.parametrize(
    ("text", "field"),
    [
        (GOOD + "[shuttle]\ngoal_s_m = 300.0\n", "$.shuttle.goal_s_m"),
        ('title = "t"\n[road]\nmap = "no.json"\nfrom_stop = "A"\nto_stop = "B"\n', "$.road.map"),
        (
            f'title = "t"\n[road]\nmap = "{SHIPPED.parent}/maps/snow-lion/map.json"\n'
            'from_stop = "NN7"\nto_stop = "nowhere"\n',
            "$.road.to_stop",
        ),
    ],
)
def test_a_file_that_cannot_be_driven_says_which_field(tmp_path: Path, text: str, field: str) -> None:
    found = load_scenario(written(tmp_path, text))
    with pytest.raises(ScenarioError, match=re.escape(field)):
        scene_of(found, "s", Profile(), tmp_path)


def test_folders_are_searched_and_empty_ones_refused(tmp_path: Path) -> None:
    assert len(scenario_paths([SHIPPED])) >= 15
    with pytest.raises(ScenarioError, match="no scenario files"):
        scenario_paths([tmp_path])
    with pytest.raises(ScenarioError, match=r"nowhere\.toml"):
        load_scenario(tmp_path / "nowhere.toml")
