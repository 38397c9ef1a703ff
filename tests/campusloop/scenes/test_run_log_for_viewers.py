"""What a viewer other than ours is given: every message as its schema says, on a map, with its frames."""

import base64
import json

import jsonschema_rs
import numpy as np
import pytest
from mcap.reader import make_reader

from campusloop.scenes.scenario_files.scenario import drive
from campusloop.scenes.scenario_files.scenario_file import load_scenario
from campusloop.scenes.stacks import profile_of

SCENARIO = """
title = "Somebody crosses"
max_time_s = 6.0
[road]
path = [[0, 0], [60, 0]]
[[road.area]]
id = "crossing"
kind = "crossing"
s_m = 30.0
length_m = 4.0
reach_m = 6.0
[[camera]]
area = "crossing"
[[person]]
at = [30, 5]
heading_deg = -90
way = [[30, -5]]
speed_mps = 1.2
"""

Found = list[tuple[str, str, bytes, dict]]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Found:
    """(topic, schema's name, schema, message) of everything in JSON of a run that was driven."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "scene.toml").write_text(SCENARIO)
    drive(load_scenario(folder / "scene.toml"), "scene", profile_of("snow_lion"), folder, folder / "runs")
    (path,) = (folder / "runs").rglob("*.mcap")
    with path.open("rb") as file:
        return [
            (channel.topic, schema.name, schema.data, json.loads(message.data))
            for schema, channel, message in make_reader(file).iter_messages()
            if schema is not None
        ]


def messages(found: Found, topic: str) -> list[dict]:
    return [message for name, _, _, message in found if name == topic]


def test_every_message_is_as_its_schema_says(found: Found) -> None:
    validators = {name: jsonschema_rs.validator_for(schema.decode()) for _, name, schema, _ in found}
    assert {
        "foxglove.FrameTransform",
        "foxglove.PoseInFrame",
        "foxglove.LocationFix",
        "foxglove.SceneUpdate",
    } <= set(validators)
    for topic, name, _, message in found:
        assert validators[name].is_valid(message), (topic, next(validators[name].iter_errors(message)))


def test_schemas_name_every_field_that_is_sent(found: Found) -> None:
    """A viewer takes fields from the schema: what it does not name is not shown."""
    for _, name, schema, message in found:
        if name.startswith("foxglove."):
            assert unnamed(json.loads(schema), message) == []


def unnamed(schema: dict, value: object) -> list[str]:
    if isinstance(value, dict):
        known = schema["properties"]
        return [name for name in value if name not in known] + [
            name for key, inner in value.items() if key in known for name in unnamed(known[key], inner)
        ]
    if isinstance(value, list):
        return [name for inner in value for name in unnamed(schema["items"], inner)]
    return []


def test_everything_is_in_a_frame_that_a_transform_leads_to(found: Found) -> None:
    frames = {"map"} | {one["child_frame_id"] for one in messages(found, "/tf")}
    assert {one["parent_frame_id"] for one in messages(found, "/tf")} == {"map"}
    for _, _, _, message in found:
        assert message.get("frame_id", "map") in frames
        assert {one["frame_id"] for one in message.get("entities", ())} <= frames


def test_the_map_is_told_before_anything_that_lies_on_it(found: Found) -> None:
    assert found[0][0] == "/map"
    entities = {one["id"]: one for one in found[0][3]["entities"]}
    assert entities["lanes"]["lifetime"] == {"sec": 0, "nsec": 0}
    assert len(entities["observation areas"]["lines"]) == 2  # the outline and its stop line


def test_the_scene_shows_who_is_around_where_they_go_and_why_it_is_slow(found: Found) -> None:
    scenes = [{one["id"]: one for one in scene["entities"]} for scene in messages(found, "/scene")]
    assert any(scene["tracks"]["cylinders"] for scene in scenes)
    people = [scene["tracks"] for scene in scenes if scene["tracks"]["cylinders"]]
    assert people[0]["metadata"] == [{"key": "tracks_by", "value": "tracker"}]
    assert all(one["texts"][0]["text"].endswith(" pedestrian") for one in people)
    # 1.2 m/s: the arrow shows the next second.
    (arrow,) = people[-1]["arrows"]
    assert arrow["shaft_length"] + arrow["head_length"] == pytest.approx(1.2, abs=0.3)
    assert any(scene["predictions"]["lines"] for scene in scenes)
    assert any(scene["watched areas"]["lines"] for scene in scenes)
    driven = [scene["path"]["lines"][0] for scene in scenes if scene["path"]["lines"]]
    assert driven
    assert all(len(one["colors"]) == len(one["points"]) for one in driven)
    assert "km/h" in scenes[-1]["shuttle"]["texts"][0]["text"]


def test_points_of_a_scan_lie_at_the_pose_of_their_moment(found: Found) -> None:
    clouds = messages(found, "/perception/points")
    assert len(clouds) == 7  # one a second, of 6 s and their end
    poses = messages(found, "/ego/pose")
    for cloud in clouds:
        points = np.frombuffer(base64.b64decode(cloud["data"]), np.float32).reshape(-1, 3)
        assert len(points) <= 1200
        at = min(poses, key=lambda one: abs(seconds(one) - seconds(cloud)))
        assert cloud["pose"]["position"]["x"] == pytest.approx(at["pose"]["position"]["x"], abs=0.3)


def seconds(message: dict) -> float:
    return message["timestamp"]["sec"] % 1000 + 1e-9 * message["timestamp"]["nsec"]
