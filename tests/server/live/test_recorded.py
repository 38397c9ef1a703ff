"""What a replayed run shows beside the vehicle's own words: where it was going."""

from datetime import UTC, datetime

import pytest

from contract.geometry import Pose2
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.wire.messages import AreaReport, DrivingView, Order, Status, Visit
from server.domain.fleet.vehicles import Vehicle
from server.domain.orders.orders import IssuedOrder, OrderState
from server.domain.record.runs import Run
from server.live.recorded import Report, recorded_scenes
from server.live.scene import AreaScene, Scene, VehicleScene
from tests.server.feeds.roads.shipped import CAMPUS_MAP

NOON = datetime(2026, 9, 1, 12, tzinfo=UTC)


@pytest.fixture(scope="module")
def network() -> RoadNetwork:
    return RoadNetwork(load_map(CAMPUS_MAP))


@pytest.fixture(scope="module")
def lanes(network: RoadNetwork) -> tuple[str, str]:
    """Two lanes that follow each other."""
    lane = max(network.road_map.lanes, key=lambda lane: network.lines[lane.lane_id].length_m)
    return lane.lane_id, lane.successors[0]


def scene_of(network: RoadNetwork, lanes: tuple[str, str], **changes: object) -> VehicleScene:
    return the_scene(network, lanes, a_status(network, lanes, **changes)).vehicles[0]


def a_status(network: RoadNetwork, lanes: tuple[str, str], **changes: object) -> Status:
    first, _ = lanes
    facts = {"lane_id": first, "s_m": 5.0, "order_id": "order-1", "revision": 2, "visit_id": "visit-1"}
    return Status(
        epoch=1,
        stamp_ns=0,
        pose_map=Pose2(*network.pose(first, 5.0)),
        speed_mps=3.0,
        accel_mps2=0.0,
        steer_rad=0.0,
        mode="autonomous",
        battery_ratio=0.8,
        doors_open=False,
        **(facts | changes),  # type: ignore[arg-type]
    )


def the_scene(network: RoadNetwork, lanes: tuple[str, str], status: Status) -> Scene:
    first, then = lanes
    visits = (
        Visit("visit-1", "pickup", "library", first, 20.0, (first,)),
        Visit("visit-2", "rest", "", then, 3.0, (first, then)),
    )
    payload = Order(1, "order-1", 2, network.map_version, visits, (), 0)
    order = IssuedOrder("campus", "shuttle-1", "order-1", 2, 1, OrderState.ACCEPTED, payload, NOON)
    (scene,) = recorded_scenes(
        Run("campus", "shuttle-1", "boot-1", NOON, "1", "gem", network.map_version),
        Vehicle("campus", "shuttle-1", "Shuttle 1", 6, 1, NOON, held=True, in_service=False),
        (Report(1000, status),),
        {},
        {("order-1", 2): order},
        network,
    )
    return scene


def test_the_way_ahead_begins_at_the_vehicle_and_ends_where_its_order_ends(
    network: RoadNetwork, lanes: tuple[str, str]
) -> None:
    shown = scene_of(network, lanes)
    assert shown.task.next_stop == "library"
    assert shown.task.route[0] == pytest.approx(network.pose(lanes[0], 5.0)[:2], abs=0.01)
    assert shown.task.route[-1] == pytest.approx(network.pose(lanes[1], 3.0)[:2], abs=0.01)


def test_what_the_vehicle_is_now_does_not_show_in_its_recording(
    network: RoadNetwork, lanes: tuple[str, str]
) -> None:
    """It was recalled and held since."""
    facts = scene_of(network, lanes).facts
    assert (facts.connected, facts.held, facts.in_service) == (True, False, True)


def test_a_vehicle_on_its_way_to_rest_has_no_next_stop(network: RoadNetwork, lanes: tuple[str, str]) -> None:
    shown = scene_of(network, lanes, visit_id="visit-2", s_m=30.0)
    assert shown.task.next_stop == ""
    assert shown.task.route[0] == pytest.approx(network.pose(lanes[0], 30.0)[:2], abs=0.01)


@pytest.mark.parametrize("other", [{"order_id": ""}, {"revision": 3}, {"visit_id": ""}])
def test_no_way_is_made_up_for_an_order_that_nobody_knows(
    network: RoadNetwork, lanes: tuple[str, str], other: dict[str, object]
) -> None:
    shown = scene_of(network, lanes, **other)
    assert shown.task.route == ()
    assert shown.task.next_stop == ""


def test_a_recorded_driving_view_is_shown_with_what_cameras_had_told_by_then(
    network: RoadNetwork, lanes: tuple[str, str]
) -> None:
    told = (AreaReport("zebra", 1, 3, 0.25), AreaReport("junction", 2))
    status = a_status(network, lanes, driving=DrivingView("yielding", (0.0, 0.0, 5.0, 0.0), (), told))
    scene = the_scene(network, lanes, status)
    shown = scene.vehicles[0].status
    assert shown is not None
    assert shown.driving == status.driving
    assert scene.areas == (AreaScene("zebra", 3, 750),)
