"""Traffic signs in the scene for viewers: at their places, told apart by words and colours."""

import json

import jsonschema_rs
import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.runlog.foxglove_schemas import SCHEMAS
from tests.contract.roads.ring_map import ring_map
from vehicle_agent.config import Body, Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.tick import tick
from vehicle_agent.runtime.recording.viewer_scene import ViewerScene
from vehicle_agent.signals import Detections, Inputs, SeenSign
from vehicle_agent.stacks.gem import gem

SIGNS = (
    SeenSign(4, "stop", Pose2(10.0, 3.0, 3.1), 9.0),
    SeenSign(5, "yield", Pose2(24.0, -7.0, 2.0), 25.0),
    SeenSign(6, "board", Pose2(30.0, 40.0, 0.0), 49.0),
    SeenSign(7, "other", Pose2(-5.0, 0.0, 0.0), 6.0),
)


def test_each_sign_stands_at_its_place_with_what_it_is_and_how_far() -> None:
    car = gem(Profile(), ring_map())
    flow = tick(initial_state(car), Inputs(1_000), car)[1].flow
    flow = msgspec.structs.replace(
        flow,
        ego=msgspec.structs.replace(flow.ego, pose_map=Pose2(0.0, 0.0, 0.0)),
        detections=Detections(5, np.empty((0, 2)), False, signs=SIGNS),
    )
    message = ViewerScene("s1", Body(), ()).scene(flow, 1_700_000_000_000_000_000)
    jsonschema_rs.validator_for(SCHEMAS["foxglove.SceneUpdate"].decode()).validate(json.loads(message))
    entities = {one["id"]: one for one in json.loads(message)["entities"]}
    signs = entities["signs"]
    assert [one["text"] for one in signs["texts"]] == [
        "stop 10 m",
        "yield 25 m",
        "sign, not read yet 50 m",
        "other sign 5 m",
    ]
    boards = signs["cubes"][1::2]
    assert [(one["pose"]["position"]["x"], one["pose"]["position"]["y"]) for one in boards] == [
        (10.0, 3.0),
        (24.0, -7.0),
        (30.0, 40.0),
        (-5.0, 0.0),
    ]
    assert len({json.dumps(one["color"]) for one in boards[:3]}) == 3
    # This stack has no tracks, and names no finder of them.
    assert entities["tracks"]["metadata"] == []
