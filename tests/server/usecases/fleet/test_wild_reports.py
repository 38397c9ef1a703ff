"""One vehicle reports what no vehicle can do, within the wire's bounds: the fleet goes on."""

from typing import Any

import msgspec
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import POSITION_M_MAX, Pose2
from contract.wire.codec import decode_from_vehicle, encode
from contract.wire.messages import Status
from server.domain.fleet.vehicles import StatusReport
from server.domain.rides.rides import RideState
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

ROAD_MAP = shipped_map("snow-lion")
LANES = [lane.lane_id for lane in ROAD_MAP.lanes]


def extreme(low: float, high: float) -> st.SearchStrategy[float]:
    return st.one_of(st.sampled_from([low, high, 0.0, 1e-300]), st.floats(low, high))


wild_fields: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {},
    optional={
        "pose_map": st.builds(
            Pose2,
            extreme(-POSITION_M_MAX, POSITION_M_MAX),
            extreme(-POSITION_M_MAX, POSITION_M_MAX),
            extreme(-10.0, 10.0),
        ),
        "speed_mps": extreme(-100.0, 100.0),
        "accel_mps2": extreme(-1000.0, 1000.0),
        "steer_rad": extreme(-10.0, 10.0),
        "battery_ratio": extreme(-1.0, 2.0),
        "s_m": extreme(-POSITION_M_MAX, POSITION_M_MAX),
        "lane_id": st.sampled_from([*LANES[:20], "", "no lane"]),
        "stamp_ns": st.sampled_from([0, 2**63 - 1, -(2**63) + 1]),
        "revision": st.sampled_from([0, 2**53 - 1]),
        "visit_id": st.sampled_from(["", "no visit"]),
        "aboard": st.sampled_from([(), ("no ride",) * 200]),
        "mode": st.sampled_from(["autonomous", "held", "manual", "minimal_risk", "fault"]),
    },
)


@settings(max_examples=12, deadline=None)
@given(st.lists(wild_fields, min_size=1, max_size=6))
def test_a_vehicle_that_reports_nonsense_keeps_no_rider_from_another_shuttle(
    reports: list[dict[str, Any]],
) -> None:
    campus = CampusUnderTest(ROAD_MAP)
    fleet = FakeFleet(campus, ROAD_MAP, 3).start()
    fleet.shuttles[1].report()
    fleet.shuttles[2].report()
    for fields in reports:
        wild = msgspec.structs.replace(fleet.shuttles[0].status(), **fields)
        received = decode_from_vehicle(encode(wild))
        assert isinstance(received, Status)
        report = StatusReport("shuttle-1", "boot-1", campus.clock.now(), received)
        # An assertion in `beat` would say that two shuttles hold the same section.
        for _ in range(4):
            campus.do(lambda uow, report=report: fleet.beat(uow, [report]))
    ride = fleet.book("NN20", "C6")
    assert ride.state is RideState.ASSIGNED
    campus.close()
