"""A camera at a crossing, over the real socket endpoint in virtual time, and who hears of it."""

import json
from pathlib import Path
from typing import Any

import msgspec
import pytest

from contract.geometry import Pose2
from contract.roads.areas import outline_array
from contract.roads.load import encode_map
from contract.roads.model import ObservationArea
from contract.roads.network import RoadNetwork
from contract.wire.messages import Presence
from server.live.scene import Snapshot
from server.live.viewer import EverythingScope, RideScope, Viewer
from server.usecases.fleet import campus
from server.usecases.record import identity
from tests.server.api.server_under_test import ServerUnderTest, snow_lion
from tests.server.api.sockets.open_socket import OpenSocket, bearer
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

ROADS = RoadNetwork(snow_lion())
LANE = snow_lion().lanes[0]


def crossing() -> ObservationArea:
    x_m, y_m, _ = ROADS.pose(LANE.lane_id, 30.0)
    corners = tuple((x_m + a, y_m + b) for a, b in ((-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)))
    return ObservationArea("zebra", "crossing", corners, ((LANE.lane_id, 20.0),))


class Camera(OpenSocket):
    """A camera on /ws/infrastructure."""

    def __init__(self, server: ServerUnderTest, secret: str) -> None:
        super().__init__(server, "/ws/infrastructure", bearer(secret))

    def report(self, **report: Any) -> None:
        self.say(json.dumps({"type": "presence_report", **report}), 0.2)

    def refusals(self) -> list[str]:
        return [json.loads(text)["code"] for text in self.texts]


@pytest.fixture
def watched(tmp_path: Path) -> Any:
    server = ServerUnderTest(tmp_path, with_map=False)
    road_map = msgspec.structs.replace(snow_lion(), observation_areas=(crossing(),), map_version="")
    server.transact(lambda uow: campus.load_map(uow, encode_map(road_map), "test", activate=True))
    yield server
    server.close()


def token(server: ServerUnderTest, *scopes: str) -> str:
    made = server.transact(
        lambda uow: identity.create_developer_token(uow, "gate camera", scopes, 1e6, "operator")
    )
    secret: str = made.secret
    return secret


def a_vehicle(server: ServerUnderTest, name: str, s_m: float) -> SpokenVehicle:
    server.enrol(name, VehicleKeyPair(name).public_base64)
    vehicle = SpokenVehicle(server, name).dial().hello()
    x_m, y_m, yaw_rad = ROADS.pose(LANE.lane_id, s_m)
    vehicle.status(x_m, y_m, yaw_rad, lane_id=LANE.lane_id, s_m=s_m)
    server.elapse(0.5)
    return vehicle


def test_vehicles_near_the_area_hear_it_and_those_far_away_do_not(watched: ServerUnderTest) -> None:
    near, far = a_vehicle(watched, "shuttle-1", 10.0), a_vehicle(watched, "shuttle-2", 300.0)
    camera = Camera(watched, token(watched, "infrastructure"))
    camera.report(area_id="zebra", count=2, age_s=0.3)
    word = near.last(Presence)
    assert (word.area_id, word.count) == ("zebra", 2)
    age_s = watched.clock.now().timestamp() - word.server_ns * 1e-9
    assert 0.3 <= age_s < 0.7
    assert not any(isinstance(message, Presence) for message in far.heard)
    assert camera.refusals() == []


def test_consoles_see_it_and_passengers_do_not(watched: ServerUnderTest) -> None:
    Camera(watched, token(watched, "infrastructure")).report(area_id="zebra", count=1)
    board = watched.services.feed.board
    first = Viewer(EverythingScope()).next_message(board, 1)
    assert isinstance(first, Snapshot)
    assert [(area.area_id, area.count) for area in first.scene.areas] == [("zebra", 1)]
    private = Viewer(RideScope("ride-1")).next_message(board, 1)
    assert isinstance(private, Snapshot)
    assert private.scene.areas == ()


def test_a_delta_tells_an_area_when_its_camera_speaks(watched: ServerUnderTest) -> None:
    camera = Camera(watched, token(watched, "infrastructure"))
    watched.elapse(1.0)
    board, viewer = watched.services.feed.board, Viewer(EverythingScope())
    viewer.next_message(board, 1)
    assert viewer.next_message(board, 2) is None
    camera.report(area_id="zebra", count=3)
    delta = viewer.next_message(board, 3)
    assert delta is not None
    assert not isinstance(delta, Snapshot)
    assert [area.count for area in delta.areas] == [3]
    assert viewer.next_message(board, 4) is None


@pytest.mark.parametrize("scopes", [("read",), ("read", "drive")])
def test_a_token_without_the_scope_is_not_let_in(watched: ServerUnderTest, scopes: tuple[str, ...]) -> None:
    camera = Camera(watched, token(watched, *scopes))
    assert camera.refusals() == ["scope_missing"]
    assert camera.closed == 4401


def test_an_unknown_token_is_not_let_in(watched: ServerUnderTest) -> None:
    camera = Camera(watched, "guess")
    assert camera.refusals() == ["token_invalid"]
    assert camera.closed == 4401


@pytest.mark.parametrize(
    ("frame", "code"),
    [
        ('{"type":"presence_report","area_id":"nowhere","count":1}', "area_unknown"),
        ('{"type":"presence_report","area_id":"zebra","count":-1}', "malformed"),
        ('{"type":"presence_report","area_id":"zebra","count":1,"age_s":1e9}', "malformed"),
        ('{"type":"presence_report","area_id":"zebra","count":1,"age_s":NaN}', "malformed"),
        ('{"type":"hello"}', "malformed"),
        ("not json", "malformed"),
        ("[" * 1500, "malformed"),
        ("x" * 3000, "malformed"),
    ],
)
def test_what_is_no_word_is_refused_and_the_camera_goes_on(
    watched: ServerUnderTest, frame: str, code: str
) -> None:
    camera = Camera(watched, token(watched, "infrastructure"))
    camera.say(frame, 0.2)
    assert camera.refusals() == [code]
    camera.report(area_id="zebra", count=1)
    assert camera.closed is None
    assert watched.services.feed.board.areas["zebra"][1].count == 1


def test_a_camera_that_floods_is_heard_ten_times_a_second_at_most(watched: ServerUnderTest) -> None:
    vehicle = a_vehicle(watched, "shuttle-1", 10.0)
    camera = Camera(watched, token(watched, "infrastructure"))
    for count in range(100):
        text = json.dumps({"type": "presence_report", "area_id": "zebra", "count": count})
        camera.frames.put_nowait({"type": "websocket.receive", "text": text})
    watched.elapse(1.0)
    assert sum(isinstance(message, Presence) for message in vehicle.heard) == 1


def test_a_camera_that_leaves_ends_its_task(watched: ServerUnderTest) -> None:
    camera = Camera(watched, token(watched, "infrastructure"))
    camera.leave()
    assert camera.task.done()
    assert camera.task.exception() is None


def test_the_area_lies_around_its_middle() -> None:
    x_m, y_m, _ = ROADS.pose(LANE.lane_id, 30.0)
    assert outline_array(crossing()).mean(axis=0) == pytest.approx((x_m, y_m))
    assert Pose2(x_m, y_m, 0.0).x_m == x_m
