import msgspec
import numpy as np
import pytest

from contract.wire.messages import AreaReport, DrivingView
from tests.contract.roads.ring_map import ring_map
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.driving_view import (
    PATH_POINTS_MAX,
    TRACKS_MAX,
    driving_view,
    report_with_driving_view,
)
from vehicle_agent.onboard.tick import tick
from vehicle_agent.signals import (
    PEDESTRIAN,
    Flow,
    Inputs,
    Outputs,
    PedestrianPresence,
    Predictions,
    Tracks,
    WatchedArea,
)
from vehicle_agent.stacks.gem import gem


@pytest.fixture(scope="module")
def outputs() -> Outputs:
    car = gem(Profile(), ring_map())
    return tick(initial_state(car), Inputs(1_000), car)[1]


def a_flow(
    outputs: Outputs, away_m: list[float], yields_to: tuple[int, ...] = (), speed_mps: float = 1.0
) -> Flow:
    """People in a row north of the vehicle, all walking east."""
    n = len(away_m)
    at = outputs.flow.ego.pose_map
    poses = np.column_stack((np.full(n, at.x_m), at.y_m + np.array(away_m), np.zeros(n)))
    velocities = np.tile((speed_mps, 0.0), (n, 1))
    tracks = Tracks(1_000, np.arange(n), np.full(n, PEDESTRIAN), poses, velocities, np.full((n, 2), 0.5))
    times = np.arange(0.0, 5.0, 0.25)
    ways = np.repeat(poses[:, None, :], len(times), axis=1)
    ways[:, :, 0] += speed_mps * times
    world = msgspec.structs.replace(
        outputs.flow.world,
        stamp_ns=2_000_000_000,
        tracks=tracks,
        predictions=Predictions(1_000, times, ways, np.zeros((n, len(times)))),
        watched=(WatchedArea("near", (0, 1)), WatchedArea("quiet", ())),
        presence=(PedestrianPresence(1_500_000_000, "near", 4),),
    )
    way = np.column_stack((np.linspace(0.0, 60.0, 200), np.zeros(200)))
    path = msgspec.structs.replace(
        outputs.flow.path, points_map=way, limited_by="yielding", yields_to=yields_to
    )
    return msgspec.structs.replace(outputs.flow, world=world, path=path)


def test_the_nearest_people_are_told_each_with_where_it_is_expected(outputs: Outputs) -> None:
    flow = a_flow(outputs, [30.0, 5.0, 80.0], yields_to=(1,))
    near, far = driving_view(flow).tracks
    x_m = round(outputs.flow.ego.pose_map.x_m, 2)
    assert (near.track_id, near.kind, near.yielded_to) == (1, "pedestrian", True)
    assert near.ahead[::2] == pytest.approx((x_m + 1.0, x_m + 2.0, x_m + 3.0), abs=0.011)
    assert (far.track_id, far.yielded_to) == (0, False)


def test_who_stands_has_no_way_ahead(outputs: Outputs) -> None:
    (one,) = driving_view(a_flow(outputs, [5.0], speed_mps=0.0)).tracks
    assert one.ahead == ()


def test_a_crowd_and_a_long_path_stay_small(outputs: Outputs) -> None:
    shown = driving_view(a_flow(outputs, [1.0 + 0.3 * k for k in range(100)]))
    assert (len(shown.tracks), len(shown.path)) == (TRACKS_MAX, 2 * PATH_POINTS_MAX)
    assert shown.path[:2] == (0.0, 0.0)
    assert shown.path[-2:] == (60.0, 0.0)
    assert len(msgspec.json.encode(shown)) < 4000


def test_areas_tell_what_the_vehicle_sees_and_what_a_camera_told_and_when(outputs: Outputs) -> None:
    assert driving_view(a_flow(outputs, [5.0])).areas == (
        AreaReport("near", 2, 4, 0.5),
        AreaReport("quiet", 0),
    )


def test_the_report_with_its_driving_view_survives_the_wire(outputs: Outputs) -> None:
    flow = a_flow(outputs, [5.0, 6.0], yields_to=(0,))
    report = report_with_driving_view(msgspec.structs.replace(outputs, flow=flow))
    assert report.driving is not None
    assert report.driving.limited_by == "yielding"
    assert msgspec.json.decode(msgspec.json.encode(report), type=type(report)) == report


def test_a_vehicle_that_knows_nothing_has_an_empty_driving_view(outputs: Outputs) -> None:
    assert driving_view(outputs.flow) == DrivingView(limited_by=outputs.flow.path.limited_by)
