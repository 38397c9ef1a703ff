"""What operators do with vehicles, maps, codes and tokens."""

import base64
from dataclasses import replace
from datetime import timedelta

import msgspec
import pytest

from contract.roads.load import encode_map, with_version
from server.domain.errors import (
    EnrolmentCodeUnknown,
    EnrolmentCodeUsed,
    KeyInvalid,
    KeyUnknown,
    MapInUse,
    MapInvalid,
    MapUnknown,
    ScopeMissing,
    SectionsTaken,
    SegmentConflict,
    SessionExpired,
    StopUnknown,
    TokenInvalid,
    VehicleNotPlaced,
    VehicleOutOfService,
    WrongCredentials,
)
from server.domain.record.runs import Segment
from server.domain.rides.rides import RideState
from server.usecases.fleet import campus as campuses
from server.usecases.fleet import vehicles
from server.usecases.planning import plans
from server.usecases.record import identity, retention, runs
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

KEY = base64.b64encode(bytes(range(32))).decode()


def test_a_vehicle_enrols_its_key_once_by_its_own_code(campus: CampusUnderTest) -> None:
    code = campus.enrol("v1")
    for wrong in ("guessed", ""):
        with pytest.raises(EnrolmentCodeUnknown):
            campus.do(lambda uow, wrong=wrong: vehicles.enrol(uow, wrong, "v1", KEY))
    with pytest.raises(EnrolmentCodeUnknown):
        campus.do(lambda uow: vehicles.enrol(uow, code, "v2", KEY))
    for broken in ("no base64!", base64.b64encode(b"short").decode()):
        with pytest.raises(KeyInvalid):
            campus.do(lambda uow, broken=broken: vehicles.enrol(uow, code, "v1", broken))
    with pytest.raises(KeyUnknown):
        campus.read(lambda uow: vehicles.key_of(uow, "v1"))
    campus.do(lambda uow: vehicles.enrol(uow, code, "v1", KEY))
    assert campus.read(lambda uow: vehicles.key_of(uow, "v1")) == KEY
    with pytest.raises(EnrolmentCodeUsed):
        campus.do(lambda uow: vehicles.enrol(uow, code, "v1", KEY))
    campus.do(lambda uow: vehicles.revoke_key(uow, "v1", "ann"))
    with pytest.raises(KeyUnknown):
        campus.read(lambda uow: vehicles.key_of(uow, "v1"))


def test_an_enrolment_code_expires(campus: CampusUnderTest) -> None:
    code = campus.enrol("v1")
    campus.clock.advance(campus.rules.enrolment_code_s)
    with pytest.raises(EnrolmentCodeUnknown):
        campus.do(lambda uow: vehicles.enrol(uow, code, "v1", KEY))


def test_operators_log_in_with_their_password_for_a_while(campus: CampusUnderTest) -> None:
    campus.do(lambda uow: identity.set_password(uow, "ann", "secret"))
    for name, password in (("ann", "wrong"), ("bob", "secret")):
        with pytest.raises(WrongCredentials):
            campus.sign_in(name, password)
    opened = campus.sign_in("ann", "secret")
    operator, session = campus.read(lambda uow: identity.operator_of(uow, opened.token))
    assert (operator.name, session) == ("ann", opened.session)
    assert opened.token != session.token_sha256
    campus.clock.advance(campus.rules.operator_session_s)
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, opened.token))
    campus.clock.advance(1.0)
    assert campus.do(retention.forget_old) == 1


def test_logging_out_ends_the_session_and_may_be_repeated(campus: CampusUnderTest) -> None:
    campus.do(lambda uow: identity.set_password(uow, "ann", "secret"))
    opened = campus.sign_in("ann", "secret")
    for _ in range(2):
        campus.do(lambda uow: identity.logout(uow, opened.token))
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, opened.token))


def test_a_developer_token_opens_its_scopes_until_it_expires_or_is_revoked(campus: CampusUnderTest) -> None:
    made = campus.do(lambda uow: identity.create_developer_token(uow, "ci", ["read"], 60.0, "ann"))
    assert campus.read(lambda uow: identity.developer_of(uow, made.secret, "read")) == made.token
    with pytest.raises(ScopeMissing):
        campus.read(lambda uow: identity.developer_of(uow, made.secret, "drive"))
    with pytest.raises(TokenInvalid):
        campus.read(lambda uow: identity.developer_of(uow, "guessed", "read"))
    other = campus.do(lambda uow: identity.create_developer_token(uow, "x", ["drive"], 60.0, "ann"))
    campus.do(lambda uow: identity.revoke_developer_token(uow, other.token.token_id, "ann"))
    with pytest.raises(TokenInvalid):
        campus.read(lambda uow: identity.developer_of(uow, other.secret, "drive"))
    campus.clock.advance(60.0)
    with pytest.raises(TokenInvalid):
        campus.read(lambda uow: identity.developer_of(uow, made.secret, "read"))
    assert len(campus.read(lambda uow: uow.identity.developer_tokens())) == 2


def test_a_recalled_shuttle_gives_its_waiting_rides_away_and_gets_none(driven_fleet: FakeFleet) -> None:
    campus = driven_fleet.campus
    ride = driven_fleet.book("NN20", "C6")
    first = ride.vehicle_id or ""
    campus.do(lambda uow: vehicles.recall(uow, first, "ann"))
    moved = driven_fleet.ride(ride.ride_id)
    assert moved.state is RideState.ASSIGNED
    assert moved.vehicle_id != first
    with pytest.raises(VehicleOutOfService):
        campus.do(lambda uow: plans.send_to_stop(uow, first, "C6", "ann"))
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED
    campus.do(lambda uow: vehicles.return_to_service(uow, first, "ann"))
    assert campus.read(lambda uow: enrolled_vehicle(uow, first)).accepts_rides


def test_a_shuttle_sent_to_a_stop_goes_there_after_what_it_promised(driven_fleet: FakeFleet) -> None:
    shuttle = driven_fleet.shuttles[0]
    with pytest.raises(StopUnknown):
        driven_fleet.campus.do(lambda uow: plans.send_to_stop(uow, shuttle.vehicle_id, "NOWHERE", "dev"))
    plan = driven_fleet.campus.do(lambda uow: plans.send_to_stop(uow, shuttle.vehicle_id, "NN20", "dev"))
    assert [visit.stop_id for visit in plan.ordered] == ["NN20", ""]
    driven_fleet.step()
    assert shuttle.next_visit() is not None
    driven_fleet.run_until_idle(3000.0)
    assert shuttle.driven_m > 50.0


def test_a_vehicle_is_placed_by_hand_only_on_free_road(campus: CampusUnderTest) -> None:
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 2)
    fleet.shuttles[0].connect()
    campus.enrol("shuttle-2")
    taken = fleet.shuttles[0].place
    with pytest.raises(SectionsTaken):
        campus.do(lambda uow: vehicles.place(uow, "shuttle-2", taken.lane_id, taken.s_m, "ann"))
    with pytest.raises(VehicleNotPlaced):
        campus.do(lambda uow: vehicles.place(uow, "shuttle-2", "no-lane", 1.0, "ann"))
    free = fleet.shuttles[1].place
    placed = campus.do(lambda uow: vehicles.place(uow, "shuttle-2", free.lane_id, free.s_m, "ann"))
    assert placed.placed
    held = campus.read(lambda uow: {o.vehicle_id: o.held_ids for o in uow.sections.all()})
    assert set(held) == {"shuttle-1", "shuttle-2"}


def test_maps_are_checked_stored_once_and_changed_only_while_nobody_drives(driven_fleet: FakeFleet) -> None:
    campus = driven_fleet.campus
    for broken in (b"", b"{}", encode_map(shipped_map("shanghai-university"))):
        with pytest.raises(MapInvalid):
            campus.do(lambda uow, broken=broken: campuses.load_map(uow, broken, "ann"))
    slower = tuple(
        msgspec.structs.replace(lane, speed_limit_mps=1.0) for lane in shipped_map("snow-lion").lanes
    )
    other = with_version(
        msgspec.structs.replace(shipped_map("snow-lion"), name="Repainted", lanes=slower, map_version="")
    )
    stored = campus.do(lambda uow: campuses.load_map(uow, encode_map(other), "ann"))
    assert not stored.active
    with pytest.raises(MapUnknown):
        campus.do(lambda uow: campuses.activate_map(uow, "0000", "ann"))
    driven_fleet.book("NN20", "C6")
    with pytest.raises(MapInUse, match="under way"):
        campus.do(lambda uow: campuses.activate_map(uow, stored.map_version, "ann"))
    driven_fleet.run_until_idle(4000.0)
    campus.do(lambda uow: campuses.activate_map(uow, stored.map_version, "ann"))
    assert campus.read(lambda uow: uow.network().road_map).name == "Repainted"
    assert len(campus.read(campuses.stops)) == 7


def a_segment(fleet: FakeFleet, number: int, sha256: str) -> Segment:
    now = fleet.campus.clock.now()
    return Segment("snow-lion", "shuttle-1", "boot-1", number, sha256, 10, 0, 1, now)


def test_segments_are_entered_once_and_never_replaced(fleet: FakeFleet) -> None:
    campus = fleet.campus
    first = a_segment(fleet, 0, "aa")
    assert campus.do(lambda uow: runs.add_segment(uow, first))
    assert not campus.do(lambda uow: runs.add_segment(uow, first))
    with pytest.raises(SegmentConflict):
        campus.do(lambda uow: runs.add_segment(uow, a_segment(fleet, 0, "bb")))
    with pytest.raises(SegmentConflict):
        campus.do(lambda uow: runs.add_segment(uow, a_segment(fleet, 1, "aa")))
    run = campus.read(lambda uow: uow.views.run("shuttle-1", "boot-1"))
    assert run is not None
    assert [segment.sha256 for segment in run.segments] == ["aa"]


def test_positions_become_history_and_old_ones_are_forgotten(fleet: FakeFleet) -> None:
    campus = fleet.campus
    shuttle = fleet.shuttles[0]
    began = campus.clock.now()
    campus.clock.advance(1.0)
    shuttle.report()
    shuttle.report()
    later = campus.clock.now() + timedelta(seconds=1)
    points = campus.read(lambda uow: uow.views.history(shuttle.vehicle_id, began, later))
    assert [point.received_at for point in points] == [began, began + timedelta(seconds=1)]
    campus.clock.advance(campus.rules.history_days * 86400.0)
    assert campus.do(retention.forget_old) == 2
    assert campus.read(lambda uow: uow.views.history(shuttle.vehicle_id, began, later)) != points


def test_a_retired_shuttle_is_nowhere_and_its_key_opens_no_session(driven_fleet: FakeFleet) -> None:
    campus = driven_fleet.campus
    driven_fleet.book("NN20", "C6")
    for shuttle in driven_fleet.shuttles:
        before = campus.read(lambda uow, s=shuttle: enrolled_vehicle(uow, s.vehicle_id))  # type: ignore[misc]
        planned = campus.read(lambda uow, s=shuttle: uow.plans.get(s.vehicle_id))  # type: ignore[misc]
        campus.do(lambda uow, s=shuttle: vehicles.retire(uow, s.vehicle_id, "ann"))  # type: ignore[misc]
        gone = campus.read(lambda uow, s=shuttle: uow.vehicles.get(s.vehicle_id))  # type: ignore[misc]
        assert gone is not None
        assert gone.retired
        assert (gone.in_service, gone.placed, gone.connected) == (False, False, False)
        assert gone.epoch == before.epoch + 1
        plan = campus.read(lambda uow, s=shuttle: uow.plans.get(s.vehicle_id))  # type: ignore[misc]
        assert planned is not None
        assert plan is not None
        assert (plan.visits, plan.resting_place_id) == ((), "")
        assert plan.version > planned.version
        held = campus.read(lambda uow: uow.sections.all())
        assert shuttle.vehicle_id not in {occupancy.vehicle_id for occupancy in held}


def test_a_revoked_key_ends_the_session_that_it_opened(campus: CampusUnderTest) -> None:
    code = campus.enrol("v1")
    campus.do(lambda uow: vehicles.enrol(uow, code, "v1", KEY))
    before = campus.read(lambda uow: enrolled_vehicle(uow, "v1"))
    campus.do(lambda uow: uow.vehicles.save(replace(before, connected=True)))
    campus.do(lambda uow: vehicles.revoke_key(uow, "v1", "ann"))
    fenced = campus.read(lambda uow: enrolled_vehicle(uow, "v1"))
    assert (fenced.epoch, fenced.connected) == (before.epoch + 1, False)


def test_a_vehicle_is_placed_from_the_beginning_of_a_lane_to_its_end(campus: CampusUnderTest) -> None:
    campus.enrol("shuttle-1")
    lane_id = "east-4"
    length_m = campus.read(lambda uow: uow.network().lines[lane_id].length_m)
    for s_m in (-0.1, length_m + 0.1):
        with pytest.raises(VehicleNotPlaced, match=f"no lane {lane_id} with a place at"):
            campus.do(lambda uow, s=s_m: vehicles.place(uow, "shuttle-1", lane_id, s, "ann"))  # type: ignore[misc]
    for s_m in (0.0, length_m):
        placed = campus.do(lambda uow, s=s_m: vehicles.place(uow, "shuttle-1", lane_id, s, "ann"))  # type: ignore[misc]
        assert placed.placed
