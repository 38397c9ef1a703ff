"""What passengers on board see: where the shuttle goes, who gets on and off, why it slows or stands."""

import msgspec
import numpy as np

from contract.wire.messages import (
    CodeRefused,
    DestinationRequested,
    HelpRequested,
    RiderAlighted,
    RiderBoarded,
    SeatButtonPressed,
    Status,
    VisitKind,
)
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.mission.memory import StandingAnnouncement
from vehicle_agent.mission.state import MissionState
from vehicle_agent.onboard.driving_view import report_with_driving_view
from vehicle_agent.signals import Outputs

VISITS_MAX = 6
# A lane whose limit is lower is not taken at walking pace for ever: it only bounds the division.
_SPEED_MPS_MIN = 0.5

CabinEventView = (
    CodeRefused | DestinationRequested | HelpRequested | RiderAlighted | RiderBoarded | SeatButtonPressed
)


class CabinVisit(msgspec.Struct, frozen=True):
    """One of the next visits.

    distance_m, least_s  along the route, None if it is not known; least_s: at the speed limits, with the
                         dwells before, as if nothing slowed the shuttle down
    boarding, alighting  people of the parties that get on and off there
    """

    visit_id: str
    kind: VisitKind
    stop_id: str
    name: str
    name_en: str
    distance_m: float | None
    least_s: float | None
    boarding: int
    alighting: int


class CabinView(msgspec.Struct, frozen=True):
    """One tick for the onboard screen. It holds no boarding code and no ride.

    status           as the server gets it, with the driving view; without riders and order
    has_position     status.pose_map is where the shuttle is
    connected        the link to the server is open; None before the link has said anything
    utc_ns           the server's clock, 0 before its first word
    aboard           people of the parties aboard
    early_stop       a passenger's request to stop early is accepted and not served yet
    serving          stands at a stop for riders
    speed_mps_max    of this vehicle
    answers          what passengers did in this tick, as the mission took it
    announce, announce_zh  a sentence that begins in this tick
    shown            the operators' announcement that stands now
    """

    status: Status
    has_position: bool
    connected: bool | None
    utc_ns: int
    visits: tuple[CabinVisit, ...]
    aboard: int
    parties: int
    early_stop: bool
    serving: bool
    limited_by: SpeedLimitReason
    answers: tuple[CabinEventView, ...] = ()
    announce: str = ""
    announce_zh: str = ""
    shown: StandingAnnouncement | None = None


def cabin_view(
    outputs: Outputs, mission: MissionState, connected: bool | None, speed_mps_max: float
) -> CabinView:
    """The view of one tick; `speed_mps_max` of the vehicle bounds the speed that `least_s` assumes."""
    status = msgspec.structs.replace(
        report_with_driving_view(outputs), order_id="", visit_id="", aboard=(), hold_detail=""
    )
    flow = outputs.flow
    riders = mission.memory.aboard
    return CabinView(
        status=status,
        has_position=flow.ego.valid,
        connected=connected,
        utc_ns=flow.task.utc_ns,
        visits=_visits(mission, flow.ego.valid, speed_mps_max),
        aboard=sum(rider.party for rider in riders),
        parties=len(riders),
        early_stop=mission.temporary is not None,
        serving=mission.stage == "serving",
        limited_by=flow.path.limited_by,
        answers=tuple(_without_ride(e) for e in outputs.events if isinstance(e, CabinEventView)),
        announce=outputs.hmi.announce,
        announce_zh=outputs.hmi.announce_zh,
        shown=mission.shown_announcement(),
    )


def is_for_cabin(outputs: Outputs) -> bool:
    """Passengers must learn of this tick, whenever the next view is due."""
    return bool(outputs.hmi.announce) or any(isinstance(e, CabinEventView) for e in outputs.events)


def _without_ride(event: CabinEventView) -> CabinEventView:
    """Who shares the shuttle is nobody's business."""
    if isinstance(event, RiderBoarded | RiderAlighted | DestinationRequested):
        return msgspec.structs.replace(event, ride_id="")
    return event


def _visits(mission: MissionState, has_position: bool, speed_mps_max: float) -> tuple[CabinVisit, ...]:
    visits = [visit for visit in mission.memory.open_visits() if visit.kind != "rest"][:VISITS_MAX]
    shown = []
    dwells_s = 0.0
    for visit in visits:
        distance_m = _distance_m(mission, visit.visit_id) if has_position else None
        least_s = None
        if distance_m is not None:
            least_s = round(_driving_s(mission, distance_m, speed_mps_max) + dwells_s, 1)
            distance_m = round(distance_m, 1)
        dwells_s += visit.dwell_s
        shown.append(
            CabinVisit(
                visit_id=visit.visit_id,
                kind=visit.kind,
                stop_id=visit.stop_id,
                name=visit.name,
                name_en=visit.name_en,
                distance_m=distance_m,
                least_s=least_s,
                boarding=sum(rider.party for rider in visit.board),
                alighting=sum(rider.party for rider in visit.alight),
            )
        )
    return tuple(shown)


def _distance_m(mission: MissionState, visit_id: str) -> float | None:
    if mission.route is None or mission.is_off_route:
        return None
    s_m = mission.route.visit_s(visit_id)
    return None if s_m is None else max(0.0, s_m - mission.s_m)


def _driving_s(mission: MissionState, distance_m: float, speed_mps_max: float) -> float:
    """Time for the next `distance_m` of the route at its speed limits."""
    assert mission.route is not None, "a distance is along a route"
    line = mission.route.line
    s_m = np.clip(line.s, mission.s_m, mission.s_m + distance_m)
    speeds_mps = np.clip(line.speed_limit_mps[:-1], _SPEED_MPS_MIN, speed_mps_max)
    return float(np.sum(np.diff(s_m) / speeds_mps))
