"""What a vehicle sees: asked for, refused, out of reach, and of a recorded run."""

import base64
import hashlib
import math
from pathlib import Path

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.runlog import foxglove
from contract.runlog.records import OBSTACLE_TOPIC, ONBOARD_TOPIC, POINTS_TOPIC
from contract.wire.codec import encode
from contract.wire.messages import Command, CommandDone, OnboardScene
from contract.wire.upload import SIGNATURE_HEADER, segment_path, signed_segment
from server.usecases.record.commands import send_command
from tests.contract.runlog.test_segment import UTC_OFFSET_NS, write_segment
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = VehicleKeyPair("shuttle-1")
SCENE = "/vehicles/shuttle-1/scene"


@pytest.fixture
def vehicle(server: ServerUnderTest) -> SpokenVehicle:
    server.enrol("shuttle-1", KEY.public_base64)
    return SpokenVehicle(server).dial().hello()


def test_a_vehicle_shows_what_it_sees_and_the_answer_says_how_old_it_is(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    answer = server.post(SCENE, headers=server.sign_in())
    assert answer.status_code == 202
    first = server.get(SCENE).json()
    assert (first["request"], first["scene"], first["received_ms"]) == ("pending", None, 0)
    server.elapse(0.2)
    vehicle.event(0, CommandDone(vehicle.last(Command).command_id, True))
    vehicle.say(OnboardScene(vehicle.epoch, 7, points=(1.0, 2.0), guard="obstacle"))
    server.elapse(3.0)
    shown = server.get(SCENE).json()
    assert (shown["request"], shown["connected"]) == ("done", True)
    assert (shown["scene"]["points"], shown["scene"]["guard"]) == ([1.0, 2.0], "obstacle")
    assert 3000 <= shown["now_ms"] - shown["received_ms"] < 3600
    assert server.transact(lambda uow: uow.audit.newest(1))[0].action.action == "ask_for_scene"


def test_a_refusal_is_told_with_its_reason_and_a_request_is_over_after_a_minute(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    server.post(SCENE, headers=server.sign_in())
    server.elapse(0.2)
    vehicle.event(0, CommandDone(vehicle.last(Command).command_id, False, "ask again"))
    shown = server.get(SCENE).json()
    assert (shown["request"], shown["detail"]) == ("failed", "ask again")
    server.elapse(61.0)
    assert server.get(SCENE).json()["request"] == ""


def test_a_vehicle_out_of_reach_is_not_asked(server: ServerUnderTest) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    answer = server.post(SCENE, headers=server.sign_in())
    assert (answer.status_code, answer.json()["code"]) == (409, "vehicle_not_connected")
    assert server.get(SCENE).json()["connected"] is False
    assert server.get("/vehicles/nobody/scene").status_code == 404


def test_a_request_that_lay_too_long_is_not_sent(server: ServerUnderTest) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    server.transact(lambda uow: send_command(uow, "shuttle-1", "show_scene", "operator"))
    server.elapse(30.0)
    vehicle = SpokenVehicle(server).dial().hello()
    server.elapse(1.0)
    assert vehicle.all(Command) == []
    server.sign_in()
    shown = server.get(SCENE).json()
    assert shown["request"] == "failed"
    assert "not in reach in time" in shown["detail"]


def test_a_part_of_a_run_comes_back_with_the_cells_of_the_scan_before(
    server: ServerUnderTest, tmp_path: Path
) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    writer = write_segment(tmp_path / "0.mcap", 500, close=False)
    for k in range(1, 6):
        stamp_ns = k * 1_000_000_000
        if k != 3:
            cells = np.array([[float(k), 2.5]])
            cloud = foxglove.point_cloud(stamp_ns, cells)
            writer.add(OBSTACLE_TOPIC, stamp_ns - 100_000_000, cloud)
        if k == 1:
            # 0.5 s before the second scene, 2 m ahead and 1 m up of a vehicle that looks north.
            cloud = foxglove.scan_cloud(stamp_ns, Pose2(10.0, 20.0, math.pi / 2), np.array([[2.0, 0.0, 1.0]]))
            writer.add(POINTS_TOPIC, stamp_ns + 500_000_000, cloud)
        writer.add(ONBOARD_TOPIC, stamp_ns, encode(OnboardScene(0, stamp_ns, guard=f"{k}")))
    writer.close()
    data = (tmp_path / "0.mcap").read_bytes()
    sha256 = hashlib.sha256(data).hexdigest()
    headers = {"Vehicle-Id": "shuttle-1", SIGNATURE_HEADER: KEY.sign(signed_segment("shuttle-1", sha256))}
    assert server.run(server.client.put(segment_path(sha256), content=data, headers=headers)).is_success
    server.sign_in()
    start_ms = UTC_OFFSET_NS // 1_000_000
    params = {"from_ms": start_ms + 2000, "seconds": 3}
    found = server.get("/runs/shuttle-1/boot-1/onboard", params=params).json()
    assert [
        (one["at_ms"] - start_ms, one["scene"]["guard"], one["scene"]["points"], one["scene"]["points_age_s"])
        for one in found
    ] == [(2000, "2", [2.0, 2.5], 0.1), (3000, "3", [], 0.0), (4000, "4", [4.0, 2.5], 0.1)]
    scan = found[0]["scene"]["scan"]
    assert (scan["x_m"], scan["y_m"], scan["age_s"]) == (10.0, 20.0, 0.5)
    assert np.frombuffer(base64.b64decode(scan["offsets_cm"]), "<i2").tolist() == [0, 200, 100]
    assert [one["scene"]["scan"] for one in found[1:]] == [None, None]
