import msgspec

from contract.geometry import Pose2
from contract.wire.messages import DrivingView, FaultReport, LocalizationReport, Status
from server.live.scene import (
    REMOVALS_KEPT,
    CommandScene,
    Delta,
    IncidentsScene,
    RideScene,
    SceneBoard,
    Snapshot,
    VehicleFacts,
    VehicleScene,
    VehicleTask,
    VisitScene,
)
from server.live.viewer import HEARTBEAT_MS, EverythingScope, RideScope, Viewer


def a_vehicle(vehicle_id: str = "shuttle-1", x_m: float = 0.0, **changes: object) -> VehicleScene:
    status = Status(
        epoch=1,
        stamp_ns=0,
        pose_map=Pose2(x_m, 0.0, 0.0),
        speed_mps=3.0,
        accel_mps2=0.0,
        steer_rad=0.0,
        mode="autonomous",
        battery_ratio=0.8,
        doors_open=False,
        lane_id="lane",
        s_m=0.0,
        order_id="order-1",
        revision=1,
        visit_id="visit-1",
    )
    status = msgspec.structs.replace(status, **changes)
    return VehicleScene(vehicle_id, VehicleFacts(vehicle_id.title(), 6), status=status)


def x_of(vehicle: VehicleScene) -> float:
    assert vehicle.status is not None
    return vehicle.status.pose_map.x_m


def a_ride(ride_id: str = "ride-1", state: str = "assigned", vehicle_id: str = "shuttle-1") -> RideScene:
    return RideScene(ride_id, "K7MQ3X", state, "gate", "library", 1, vehicle_id)


def a_board() -> SceneBoard:
    board = SceneBoard("campus")
    board.map_version = "m1"
    for number in (1, 2):
        board.put_vehicle(a_vehicle(f"shuttle-{number}"))
    board.put_ride(a_ride("ride-1", vehicle_id="shuttle-1"))
    board.put_ride(a_ride("ride-2", vehicle_id="shuttle-2"))
    return board


def delta(message: object) -> Delta:
    assert isinstance(message, Delta)
    return message


def test_an_operator_gets_everything_then_only_what_changed() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    first = viewer.next_message(board, 1)
    assert isinstance(first, Snapshot)
    assert [vehicle.vehicle_id for vehicle in first.scene.vehicles] == ["shuttle-1", "shuttle-2"]
    assert len(first.scene.rides) == 2
    assert viewer.next_message(board, 2) is None
    board.put_vehicle(a_vehicle("shuttle-2", x_m=5.0))
    second = delta(viewer.next_message(board, 3))
    assert [(vehicle.vehicle_id, x_of(vehicle)) for vehicle in second.vehicles] == [("shuttle-2", 5.0)]
    assert second.rides == ()
    assert second.incidents is None


def test_a_slow_viewer_gets_the_newest_state_and_nothing_in_between() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    viewer.next_message(board, 1)
    for metre in range(100):
        board.put_vehicle(a_vehicle("shuttle-1", x_m=float(metre)))
    assert [x_of(vehicle) for vehicle in delta(viewer.next_message(board, 2)).vehicles] == [99.0]


def test_what_is_put_again_unchanged_is_no_news() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    viewer.next_message(board, 1)
    board.put_vehicle(a_vehicle("shuttle-1"))
    board.put_ride(a_ride("ride-1"))
    assert viewer.next_message(board, 2) is None


def test_what_is_gone_is_named_once() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    viewer.next_message(board, 1)
    board.remove_vehicle("shuttle-2")
    board.remove_ride("ride-2")
    news = delta(viewer.next_message(board, 2))
    assert (news.vehicles_gone, news.rides_gone) == (("shuttle-2",), ("ride-2",))
    assert viewer.next_message(board, 3) is None


def test_a_passenger_sees_the_own_ride_and_its_shuttle_alone() -> None:
    board, viewer = a_board(), Viewer(RideScope("ride-1"))
    board.incidents = IncidentsScene(open=3)
    secret = a_vehicle(
        "shuttle-1", aboard=("ride-1", "ride-9"), faults=(FaultReport("pose_missing", "stop", 0),)
    )
    command = CommandScene("command-1", "resume", "failed", "the door is open", "ann", 0)
    task = VehicleTask(visits=(VisitScene("visit-1", "stop", "pending", "gate", 2, 0, 0, ""),))
    board.put_vehicle(msgspec.structs.replace(secret, command=command, task=task))
    first = viewer.next_message(board, 1)
    assert isinstance(first, Snapshot)
    assert [ride.ride_id for ride in first.scene.rides] == ["ride-1"]
    (shuttle,) = first.scene.vehicles
    assert shuttle.status is not None
    assert (shuttle.vehicle_id, shuttle.status.aboard, shuttle.status.faults) == (
        "shuttle-1",
        ("ride-1",),
        (),
    )
    assert (shuttle.command, shuttle.task.visits) == (None, ())
    assert first.scene.incidents == IncidentsScene()
    board.put_vehicle(a_vehicle("shuttle-2", x_m=9.0))
    board.put_ride(a_ride("ride-2", "aboard", "shuttle-2"))
    assert viewer.next_message(board, 2) is None


def test_a_shuttle_that_stands_is_told_once_a_second_and_at_once_when_anything_changes() -> None:
    board, viewer = a_board(), Viewer(RideScope("ride-1"))

    def report(heard_ms: int, x_m: float = 0.0, **changes: object) -> object:
        vehicle = a_vehicle("shuttle-1", x_m, **({"speed_mps": 0.0} | changes))
        board.put_vehicle(msgspec.structs.replace(vehicle, heard_ms=heard_ms))
        return viewer.next_message(board, heard_ms)

    assert isinstance(report(1_000), Snapshot)
    assert [report(at_ms, 0.02) for at_ms in (1_200, 1_400, 1_999)] == [None] * 3
    assert delta(report(2_000, 0.02)).vehicles[0].heard_ms == 2_000
    assert report(2_200, 0.02) is None
    assert delta(report(2_400, 0.02, doors_open=True)).vehicles
    assert delta(report(2_600, 0.5, doors_open=True)).vehicles


def test_a_passenger_learns_nothing_else_that_a_shuttle_reports() -> None:
    """A new field of the status is not sent to passengers by default."""
    reported = Status(
        epoch=7,
        stamp_ns=8,
        pose_map=Pose2(1.0, 2.0, 3.0),
        speed_mps=4.0,
        accel_mps2=0.5,
        steer_rad=0.1,
        mode="held",
        battery_ratio=0.8,
        doors_open=True,
        lane_id="lane",
        s_m=9.0,
        order_id="order-1",
        revision=2,
        visit_id="visit-1",
        aboard=("ride-1",),
        screen="arriving",
        spoken="Next stop: Gate.",
        obstacle_m=5.0,
        waiting_for="section",
        faults=(FaultReport("pose_missing", "stop", 0),),
        driving=DrivingView("waypoint_speed"),
        hold_reason="operator_hold",
        hold_detail="the driver is late",
        localization=LocalizationReport("gnss_only", 0.1, 0.9),
    )
    facts = VehicleFacts("Shuttle 1", 6, 1, connected=True, held=True, charging=True, mode="held")
    task = VehicleTask("gate", 2, at_charger=True, hold_ends_ms=5, charged_at_ms=6, unavailable_since_ms=4)
    board, viewer = a_board(), Viewer(RideScope("ride-1"))
    board.put_vehicle(VehicleScene("shuttle-1", facts, task, reported, 1000))
    first = viewer.next_message(board, 1)
    assert isinstance(first, Snapshot)
    (seen,) = first.scene.vehicles
    assert seen.status is not None
    shown = {
        name for name in reported.__struct_fields__ if getattr(seen.status, name) == getattr(reported, name)
    }
    assert shown == {
        "pose_map", "speed_mps", "mode", "doors_open", "visit_id", "aboard", "screen", "spoken"
    }  # fmt: skip
    assert seen.facts == msgspec.structs.replace(facts, charging=False)
    assert (seen.task, seen.heard_ms) == (
        VehicleTask("gate", 2, hold_ends_ms=5, unavailable_since_ms=4),
        1000,
    )


def test_a_passenger_changes_shuttles_with_the_ride_and_loses_it_at_the_end() -> None:
    board, viewer = a_board(), Viewer(RideScope("ride-1"))
    viewer.next_message(board, 1)
    board.put_ride(a_ride("ride-1", "assigned", "shuttle-2"))
    moved = delta(viewer.next_message(board, 2))
    assert [vehicle.vehicle_id for vehicle in moved.vehicles] == ["shuttle-2"]
    assert moved.vehicles_gone == ("shuttle-1",)
    board.put_ride(a_ride("ride-1", "completed", "shuttle-2"))
    ended = delta(viewer.next_message(board, 3))
    assert ended.vehicles_gone == ("shuttle-2",)
    assert [ride.state for ride in ended.rides] == ["completed"]


def test_another_map_begins_with_a_new_snapshot() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    viewer.next_message(board, 1)
    board.map_version = "m2"
    again = viewer.next_message(board, 2)
    assert isinstance(again, Snapshot)
    assert again.scene.map_version == "m2"


def test_a_viewer_that_applies_every_message_ends_with_the_boards_scene() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    shown: dict[str, VehicleScene] = {}
    for step in range(40):
        name = f"shuttle-{step % 4}"
        if step % 7 == 3:
            board.remove_vehicle(name)
        else:
            board.put_vehicle(a_vehicle(name, x_m=float(step)))
        if step % 3 == 0:
            message = viewer.next_message(board, step)
            if isinstance(message, Snapshot):
                shown = {vehicle.vehicle_id: vehicle for vehicle in message.scene.vehicles}
            elif message is not None:
                shown |= {vehicle.vehicle_id: vehicle for vehicle in message.vehicles}
                for gone in message.vehicles_gone:
                    del shown[gone]
    assert shown == {key: vehicle for key, (_, vehicle) in board.vehicles.items()}


def test_a_quiet_campus_still_tells_the_time_now_and_then() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    viewer.next_message(board, 1_000)
    assert viewer.next_message(board, 1_000 + HEARTBEAT_MS - 1) is None
    assert viewer.next_message(board, 1_000 + HEARTBEAT_MS) == Delta(1_000 + HEARTBEAT_MS)
    assert viewer.next_message(board, 1_001 + HEARTBEAT_MS) is None


def test_viewers_that_know_the_same_share_a_message() -> None:
    board, first, second, late = a_board(), *(Viewer(EverythingScope()) for _ in range(3))
    for viewer in (first, second):
        viewer.next_message(board, 1)
    board.put_vehicle(a_vehicle("shuttle-2", x_m=5.0))
    shared = first.next_message(board, 3)
    assert second.next_message(board, 3) is shared
    assert isinstance(late.next_message(board, 3), Snapshot)


def test_an_item_that_changed_often_is_sent_once_in_its_newest_state() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    viewer.next_message(board, 1)
    for x_m in (5.0, 6.0, 7.0):
        board.put_vehicle(a_vehicle("shuttle-1", x_m=x_m))
        board.put_vehicle(a_vehicle("shuttle-2", x_m=x_m))
    news = delta(viewer.next_message(board, 3))
    assert news.vehicles == (a_vehicle("shuttle-1", x_m=7.0), a_vehicle("shuttle-2", x_m=7.0))


def test_a_vehicle_that_left_and_came_back_is_not_gone() -> None:
    board, viewer = a_board(), Viewer(EverythingScope())
    viewer.next_message(board, 1)
    board.remove_vehicle("shuttle-1")
    board.put_vehicle(a_vehicle("shuttle-1"))
    news = delta(viewer.next_message(board, 3))
    assert (news.vehicles, news.vehicles_gone) == ((a_vehicle("shuttle-1"),), ())


def test_who_slept_through_more_removals_than_are_kept_begins_again_with_a_snapshot() -> None:
    board, viewer, awake = a_board(), Viewer(EverythingScope()), Viewer(EverythingScope())
    viewer.next_message(board, 1)
    for number in range(REMOVALS_KEPT + 1):
        board.put_ride(a_ride(f"passing-{number}"))
        board.remove_ride(f"passing-{number}")
        awake.next_message(board, 2)
    assert isinstance(viewer.next_message(board, 3), Snapshot)
    board.remove_vehicle("shuttle-1")
    assert delta(awake.next_message(board, 4)).vehicles_gone == ("shuttle-1",)
