"""Views of the cabin for tests of what shows them."""

import msgspec

from contract.geometry import Pose2
from contract.wire.messages import DrivingView, Status
from vehicle_agent.onboard.cabin_view import CabinView, CabinVisit


def a_status(**changes: object) -> Status:
    status = Status(
        epoch=0,
        stamp_ns=1,
        pose_map=Pose2(0.0, 0.0, 0.0),
        speed_mps=2.5,
        accel_mps2=0.0,
        steer_rad=0.0,
        mode="autonomous",
        battery_ratio=0.8,
        doors_open=False,
        lane_id="",
        s_m=0.0,
        order_id="",
        revision=0,
        visit_id="",
        driving=DrivingView("yielding"),
    )
    return msgspec.structs.replace(status, **changes)


def a_cabin_visit(number: int, name: str, name_zh: str, **changes: object) -> CabinVisit:
    visit = CabinVisit(
        f"v{number}", "stop", f"stop-{number}", name_zh, name, 200.0 * number, 100.0 * number, 0, 1
    )
    return msgspec.structs.replace(visit, **changes)


def a_cabin_view(**changes: object) -> CabinView:
    view = CabinView(
        status=a_status(),
        has_position=True,
        connected=True,
        utc_ns=1_788_000_000_000_000_000,
        visits=(a_cabin_visit(1, "Library", "图书馆"),),
        aboard=1,
        parties=1,
        early_stop=False,
        serving=False,
        limited_by="yielding",
    )
    return msgspec.structs.replace(view, **changes)
