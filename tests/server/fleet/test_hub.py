"""The link end to end: in-memory pipe, session, use cases, store; in virtual time."""

from dataclasses import replace

import msgspec
import pytest

from contract.geometry import Pose2
from contract.roads.network import RoadNetwork
from contract.wire.close_reasons import close_reason
from contract.wire.codec import MAX_MESSAGE_BYTES, encode
from contract.wire.messages import (
    ClockProbe,
    ClockSample,
    Command,
    CommandDone,
    EventLogState,
    FleetVehicle,
    Goodbye,
    Grants,
    ModeChanged,
    Order,
    OrderAccepted,
    Presence,
    Status,
    Welcome,
)
from server.bus.topics import matches
from server.fleet.hub import AWAY_MAX, TAKEN_UP_WITHIN_S
from server.fleet.presence import AreaPresence
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.api.server_under_test import ServerUnderTest, snow_lion
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair, a_hello

ROADS = RoadNetwork(snow_lion())


def events_stored(server: ServerUnderTest, boot_id: str = "boot-1") -> int:
    def work(uow: UnitOfWork) -> int:
        return uow.events.count("shuttle-1", boot_id)

    stored: int = server.transact(work)
    return stored


def incident_kinds(server: ServerUnderTest) -> list[str]:
    server.sign_in()
    return [item["kind"] for item in server.get("/incidents").json()]


def at_rest(server: ServerUnderTest, vehicle: SpokenVehicle, place: int = 0) -> None:
    """Standing at a resting place of the map, free to drive."""
    rest = snow_lion().resting_places[place]
    x_m, y_m, yaw_rad = ROADS.pose(rest.lane_id, rest.s_m)
    vehicle.event(0, ModeChanged("autonomous", detail="resumed"))
    vehicle.status(x_m, y_m, yaw_rad, lane_id=rest.lane_id, s_m=rest.s_m)
    server.elapse(1.5)


def test_a_vehicle_with_its_key_is_welcomed_and_has_the_servers_clock(server: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    assert vehicle.epoch == 1
    assert server.get("/ready").json()["vehicles_connected"] == 1
    vehicle.say(ClockProbe(77))
    sample = vehicle.last(ClockSample)
    assert sample.vehicle_ns == 77
    assert sample.server_ns == pytest.approx(server.clock.now().timestamp() * 1e9, abs=1e9)


def test_a_vehicle_that_never_enrolled_is_told_to(server: ServerUnderTest) -> None:
    stranger = SpokenVehicle(server, "shuttle-9").dial().hello()
    assert stranger.goodbye == "key_unknown"
    assert stranger.closed == f"{close_reason('key_unknown').number} key_unknown"
    assert "nrol" in stranger.last(Goodbye).detail


def test_a_hello_recorded_on_one_connection_opens_no_other(server: ServerUnderTest) -> None:
    first = SpokenVehicle(server).dial()
    recorded = encode(a_hello(first.heard[0].nonce))  # type: ignore[union-attr]
    first.say(recorded)
    assert first.epoch == 1
    thief = SpokenVehicle(server).dial()
    thief.say(recorded)
    assert thief.goodbye == "nonce_wrong"
    assert first.goodbye == ""
    first.say(recorded)
    assert first.goodbye == "hello_repeated"


def test_an_old_protocol_version_is_told_which_are_spoken(server: ServerUnderTest) -> None:
    old = SpokenVehicle(server).dial().hello(protocol=0)
    assert old.goodbye == "protocol_version"
    assert "protocol 0" in old.last(Goodbye).detail


def test_who_says_nothing_after_the_challenge_is_closed(server: ServerUnderTest) -> None:
    silent = SpokenVehicle(server).dial()
    server.elapse(11.0)
    assert silent.goodbye == "hello_late"


@pytest.mark.parametrize(
    ("frame", "code"),
    [
        (b'{"type":"teleport"}', "unknown_message"),
        (b"nonsense", "malformed"),
        (b"", "malformed"),
        (b" " * (MAX_MESSAGE_BYTES + 1), "frame_too_large"),
    ],
)
def test_a_bad_frame_ends_the_session_and_loses_no_event(
    server: ServerUnderTest, frame: bytes, code: str
) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    vehicle.event(0, ModeChanged("held", detail="one"))
    vehicle.say(frame)
    assert vehicle.goodbye == code
    again = SpokenVehicle(server).dial().hello(logs=(EventLogState("boot-1", 0, 2),))
    assert again.last(Welcome).acknowledged == (EventLogState("boot-1", 1, 1),)
    again.event(1, ModeChanged("held", detail="two"))
    assert events_stored(server) == 2


def test_an_event_of_a_session_that_was_fenced_meanwhile_is_not_stored(server: ServerUnderTest) -> None:
    """Another process of the server has welcomed the vehicle, and its word on the bus is lost."""
    vehicle = SpokenVehicle(server).dial().hello()
    vehicle.event(0, ModeChanged("held", detail="one"))

    def welcomed_elsewhere(uow: UnitOfWork) -> None:
        known = uow.vehicles.get("shuttle-1")
        assert known is not None
        uow.vehicles.save(replace(known, epoch=known.epoch + 1))

    server.transact(welcomed_elsewhere)
    vehicle.event(1, ModeChanged("autonomous", detail="two"))
    assert vehicle.goodbye == "superseded"
    assert events_stored(server) == 1
    assert vehicle.acknowledged == [("boot-1", 1)]


def test_a_newer_session_of_the_same_boot_fences_the_older(server: ServerUnderTest) -> None:
    older = SpokenVehicle(server).dial().hello()
    newer = SpokenVehicle(server).dial().hello()
    assert (older.goodbye, newer.goodbye) == ("superseded", "")
    assert newer.epoch == older.epoch + 1
    newer.event(0, ModeChanged("held", detail="still heard"))
    assert events_stored(server) == 1
    assert incident_kinds(server) == []


def test_two_agents_with_one_key_are_an_incident(server: ServerUnderTest) -> None:
    older = SpokenVehicle(server, boot_id="boot-1").dial().hello()
    newer = SpokenVehicle(server, boot_id="boot-2").dial().hello()
    assert (older.goodbye, newer.goodbye) == ("key_conflict", "key_conflict")
    server.elapse(60.0)
    assert incident_kinds(server) == ["key_conflict"]


def test_neither_of_two_agents_with_one_key_is_served_until_an_operator_closes_the_incident(
    server: ServerUnderTest,
) -> None:
    for boot_id in ("boot-1", "boot-2"):
        SpokenVehicle(server, boot_id=boot_id).dial().hello()
    for boot_id in ("boot-1", "boot-2"):
        server.elapse(30.0)
        assert SpokenVehicle(server, boot_id=boot_id).dial().hello().goodbye == "key_conflict"
    headers = server.sign_in()
    (incident,) = server.get("/incidents").json()
    path = f"/incidents/{incident['incident_id']}/close"
    assert server.request("POST", path, headers=headers).status_code == 200
    assert SpokenVehicle(server, boot_id="boot-1").dial().hello().goodbye == ""


def test_a_restart_after_a_silence_is_no_conflict(server: ServerUnderTest) -> None:
    SpokenVehicle(server, boot_id="boot-1").dial().hello()
    server.elapse(4.0)
    SpokenVehicle(server, boot_id="boot-2").dial().hello()
    assert "key_conflict" not in incident_kinds(server)


def test_events_are_stored_once_in_order_and_a_gap_is_asked_for(server: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    vehicle.event(0, ModeChanged("held", detail="a"))
    vehicle.event(2, ModeChanged("held", detail="c"))
    vehicle.event(1, ModeChanged("held", detail="b"))
    vehicle.event(1, ModeChanged("held", detail="b"))
    vehicle.event(2, ModeChanged("held", detail="c"))
    assert vehicle.acknowledged == [("boot-1", n) for n in (1, 1, 2, 2, 3)]
    assert events_stored(server) == 3


def test_an_earlier_boots_events_keep_their_boot(server: ServerUnderTest) -> None:
    logs = (EventLogState("boot-0", 0, 1), EventLogState("boot-1", 0, 0))
    vehicle = SpokenVehicle(server).dial().hello(logs=logs)
    vehicle.event(0, ModeChanged("held", detail="before"), boot_id="boot-0")
    assert vehicle.acknowledged == [("boot-0", 1)]
    assert (events_stored(server, "boot-0"), events_stored(server, "boot-1")) == (1, 0)


def test_a_command_is_repeated_until_the_vehicle_has_done_it(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    vehicle = SpokenVehicle(server).dial().hello()
    given = server.post("/vehicles/shuttle-1/hold", headers=headers)
    assert given.status_code == 202
    server.elapse(0.5)
    assert [command.kind for command in vehicle.all(Command)] == ["hold"]
    server.elapse(8.0)
    assert {command.command_id for command in vehicle.all(Command)} == {given.json()["command_id"]}
    assert 2 <= len(vehicle.all(Command)) <= 4
    vehicle.event(0, CommandDone(given.json()["command_id"], True))
    repeats = len(vehicle.all(Command))
    server.elapse(8.0)
    assert len(vehicle.all(Command)) == repeats


def test_an_announcement_reaches_the_vehicle_word_for_word(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    vehicle = SpokenVehicle(server).dial().hello()
    server.post("/vehicles/shuttle-1/announce", {"text": "请稍候 / one moment"}, headers=headers)
    server.elapse(0.5)
    assert vehicle.last(Command).text == "请稍候 / one moment"


def test_a_booking_becomes_an_order_that_is_repeated_until_accepted(server: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    at_rest(server, vehicle)
    ride = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"}).json()
    assert ride["state"] == "assigned", ride
    server.elapse(0.5)
    order = vehicle.last(Order)
    boarded = [task.ride_id for visit in order.visits for task in visit.board]
    assert boarded == [ride["ride_id"]]
    assert order.visits[-1].kind == "rest"
    assert order.epoch == vehicle.epoch
    server.elapse(8.0)
    assert len([o for o in vehicle.all(Order) if o.revision == order.revision]) >= 2
    vehicle.say(OrderAccepted(vehicle.epoch, order.order_id, order.revision))
    said = len(vehicle.all(Order))
    server.elapse(8.0)
    assert len(vehicle.all(Order)) == said
    assert all(grants.order_id == order.order_id for grants in vehicle.all(Grants))


def test_the_order_waits_for_the_events_that_the_hello_announced(server: ServerUnderTest) -> None:
    first = SpokenVehicle(server).dial().hello()
    at_rest(server, first)
    server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"})
    first.pipe.cut()
    server.elapse(1.0)
    back = SpokenVehicle(server).dial().hello(logs=(EventLogState("boot-1", 1, 3),))
    back.event(1, ModeChanged("autonomous", detail="x"))
    assert back.all(Order) == []
    back.event(2, ModeChanged("autonomous", detail="y"))
    assert len(back.all(Order)) == 1


def test_a_position_at_sea_is_an_incident_and_moves_nothing(server: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    vehicle.status(1e6, 1e6, 0.0)
    server.elapse(1.0)
    assert "impossible_position" in incident_kinds(server)
    assert vehicle.all(Order) == []


def test_positions_are_on_the_scene_at_once(server: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    server.elapse(1.0)
    vehicle.status(12.5, -3.0, 0.5, speed_mps=1.5, screen="To the library")
    scene = server.services.feed.board.vehicle("shuttle-1")
    assert scene is not None
    assert scene.status is not None
    assert scene.status.pose_map == Pose2(12.5, -3.0, 0.5)
    assert (scene.status.speed_mps, scene.status.screen) == (1.5, "To the library")
    assert scene.facts.connected


def test_a_revoked_key_ends_the_session_and_opens_no_other(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    vehicle = SpokenVehicle(server).dial().hello()
    assert server.request("DELETE", "/vehicles/shuttle-1/key", headers=headers).status_code == 200
    server.elapse(0.5)
    assert vehicle.goodbye != ""
    assert SpokenVehicle(server).dial().hello().goodbye == "key_unknown"


def test_a_connection_cut_is_seen_by_operators(server: ServerUnderTest) -> None:
    server.sign_in()
    vehicle = SpokenVehicle(server).dial().hello()
    assert server.get("/vehicles/shuttle-1").json()["connected"] is True
    vehicle.pipe.cut()
    server.elapse(0.5)
    assert server.get("/vehicles/shuttle-1").json()["connected"] is False


def test_a_server_that_stops_says_so(server: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    server.run(server.hub.close())
    server.elapse(0.2)
    assert vehicle.goodbye == "server_leaving"


def test_a_farewell_that_quotes_a_long_text_fits_the_wire(server: ServerUnderTest) -> None:
    link = SpokenVehicle(server).dial().hello()
    server.hub._links["shuttle-1"].end("server_fault", 5_000 * "z")
    server.elapse(0.2)
    assert link.goodbye == "server_fault"


def many_vehicles(server: ServerUnderTest, count: int) -> list[SpokenVehicle]:
    spoken = [SpokenVehicle(server).dial().hello()]
    for number in range(2, count + 1):
        name = f"shuttle-{number}"
        server.elapse(2.0)
        server.enrol(name, VehicleKeyPair(name).public_base64)
        spoken.append(SpokenVehicle(server, name).dial().hello())
    return spoken


def sent_away(vehicles: list[SpokenVehicle]) -> int:
    return sum(vehicle.goodbye == "server_leaving" for vehicle in vehicles)


def test_a_server_that_leaves_waits_for_others_to_take_up_its_vehicles(server: ServerUnderTest) -> None:
    vehicles = many_vehicles(server, AWAY_MAX + 5)
    server.conductor.loop.create_task(server.hub.leave())
    server.elapse(0.2)
    assert sent_away(vehicles) == AWAY_MAX
    assert server.get("/ready").status_code == 503
    topic = topics.vehicle_session(server.hub.campus_id, "shuttle-1")
    server.run(server.bus.publish(topic, b'{"epoch":99}'))
    server.elapse(0.2)
    assert sent_away(vehicles) == AWAY_MAX + 1
    server.elapse(2.0)
    assert sent_away(vehicles) == AWAY_MAX + 5


def test_a_server_that_leaves_and_has_no_others_sends_all_away_at_once(server: ServerUnderTest) -> None:
    vehicles = many_vehicles(server, 3 * AWAY_MAX)
    server.conductor.loop.create_task(server.hub.leave())
    server.elapse(0.2)
    assert sent_away(vehicles) < len(vehicles)
    server.elapse(TAKEN_UP_WITHIN_S)
    assert sent_away(vehicles) == len(vehicles)


def test_a_hub_that_is_closed_listens_no_more(server: ServerUnderTest) -> None:
    def listeners() -> int:
        topic = topics.vehicle_outbox(server.hub.campus_id, "shuttle-1")
        return sum(matches(one.pattern, topic) for one in server.bus._subscriptions)

    before = listeners()
    server.run(server.hub.close())
    assert listeners() == before - 1


def test_shuttles_hear_of_each_other_while_they_are_near(server: ServerUnderTest) -> None:
    server.enrol("shuttle-2", VehicleKeyPair("shuttle-2").public_base64)
    one = SpokenVehicle(server).dial().hello()
    two = SpokenVehicle(server, "shuttle-2").dial().hello()
    one.status(0.0, 0.0, 0.0)
    two.status(50.0, 0.0, 0.5)
    server.elapse(0.5)
    mate = one.last(FleetVehicle)
    assert (mate.vehicle_id, mate.pose_map, mate.epoch) == ("shuttle-2", Pose2(50.0, 0.0, 0.5), one.epoch)
    assert not [message for message in two.heard if isinstance(message, FleetVehicle)]
    two.status(90.0, 0.0, 0.5)
    server.elapse(0.5)
    assert one.last(FleetVehicle) is mate


def test_shuttles_that_are_linked_to_another_replica_are_heard_of_and_are_sent_nothing(
    server: ServerUnderTest,
) -> None:
    one = SpokenVehicle(server).dial().hello()
    campus_id = server.hub.campus_id

    def say(topic: str, payload: bytes) -> None:
        server.run(server.bus.publish(topic, payload))
        server.elapse(0.5)

    for x_m in (30.0, 40.0):
        one.status(0.0, 0.0, 0.0)
        say(topics.vehicle_live(campus_id, "shuttle-9"), encode(a_status(x_m)))
        assert one.last(FleetVehicle).pose_map.x_m == x_m
        say(topics.vehicle_outbox(campus_id, "shuttle-9"), b"{}")
        say(topics.vehicle_session(campus_id, "shuttle-9"), b'{"epoch":7}')
        say(
            topics.area_presence(campus_id, "gate"),
            msgspec.json.encode(AreaPresence("gate", 3, 35.0, 0.0, 9)),
        )
        assert one.last(Presence).count == 3
    assert one.goodbye == ""
    assert len(one.all(Presence)) == 2


def test_a_session_that_another_replica_opened_ends_the_older_one_here(server: ServerUnderTest) -> None:
    one = SpokenVehicle(server).dial().hello()
    topic = topics.vehicle_session(server.hub.campus_id, "shuttle-1")
    for epoch, goodbye in ((one.epoch, ""), (one.epoch + 1, "superseded")):
        server.run(server.bus.publish(topic, b'{"epoch":%d}' % epoch))
        server.elapse(0.5)
        assert one.goodbye == goodbye


def a_status(x_m: float) -> Status:
    """Of a shuttle that drives along the x axis."""
    return Status(
        epoch=1,
        stamp_ns=5,
        pose_map=Pose2(x_m, 0.0, 0.0),
        speed_mps=2.0,
        accel_mps2=0.0,
        steer_rad=0.0,
        mode="autonomous",
        battery_ratio=0.9,
        doors_open=False,
        lane_id="",
        s_m=0.0,
        order_id="",
        revision=0,
        visit_id="",
    )
