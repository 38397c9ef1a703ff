"""The mission's state, with the memory that survives a crash."""

from typing import Literal

import msgspec

from contract.wire.messages import Order, OrderAccepted, OrderRejected, VehicleEvent, Visit
from contract.wire.reasons import HoldReason
from vehicle_agent.mission.boarding import SeatState
from vehicle_agent.mission.doors import Doors
from vehicle_agent.mission.memory import MissionMemory, StandingAnnouncement
from vehicle_agent.mission.order_line import LanePoint, OrderLine
from vehicle_agent.mission.placing import Placing
from vehicle_agent.mission.seat_button import TemporaryStop
from vehicle_agent.mission.sections import OccupiedSection

Stage = Literal["driving", "serving", "leaving"]


class MissionState(msgspec.Struct, frozen=True):
    """The mission's state in one tick.

    held, hold_reason, hold_s_m  held by an operator or after a start; why, and where on the line
    route         the order as a line, None without an order or before the first position
    s_m, d_m, segment  the rear axle's place on it
    standing_since_ns  0 while moving
    stage         driving; serving a stop with doors opening or open; leaving it after the dwell
    doors_open_ns  when the doors stood open at this stop, 0 before
    is_off_route  the vehicle is off its line: a driver took it elsewhere
    near_since_ns, clear_since_ns  departure check of a temporary stop: since when it waits, since when free
    near_reported  the operator was told of that wait
    resumed_ns, waved_on_ns  the task's
    wait_s_m, stop_free_since_ns  where to wait for an occupied stop, None while there is none; since when it
                  is free again, 0 while it is not
    refused_ns    when the seat button was last refused under way, 0 before
    placing       a place that an operator named and that is being tried
    pending_order  an order that came before the first position
    """

    memory: MissionMemory
    held: bool = True
    hold_reason: HoldReason | None = "just_started"
    hold_detail: str = ""
    hold_s_m: float = 0.0
    resumed_ns: int = 0
    waved_on_ns: int = 0
    route: OrderLine | None = None
    line_count: int = 0
    s_m: float = 0.0
    d_m: float = 0.0
    segment: int = 0
    is_off_route: bool = False
    place: LanePoint = LanePoint("", 0.0)
    odometer_m: float = 0.0
    stamp_ns: int = 0
    standing_since_ns: int = 0
    doors: Doors = Doors()
    doors_open_ns: int = 0
    stage: Stage = "driving"
    seats: SeatState = SeatState()
    temporary: TemporaryStop | None = None
    temporaries: int = 0
    near_since_ns: int = 0
    clear_since_ns: int = 0
    near_reported: bool = False
    wait_s_m: float | None = None
    stop_free_since_ns: int = 0
    occupied_sections: tuple[OccupiedSection, ...] = ()
    server_offset_ns: int | None = None
    announcement: str = ""
    announcement_zh: str = ""
    announced_ns: int = 0
    refused_ns: int = 0
    pending_order: Order | None = None
    placing: Placing | None = None
    events: tuple[VehicleEvent, ...] = ()
    answers: tuple[OrderAccepted | OrderRejected, ...] = ()

    def server_now_ns(self) -> int | None:
        """The server's clock now; None while its offset is unknown."""
        return None if self.server_offset_ns is None else self.stamp_ns + self.server_offset_ns

    def shown_announcement(self) -> StandingAnnouncement | None:
        """What the screens show now; None also while the server's clock is unknown: it may be over."""
        shown, now_ns = self.memory.shown, self.server_now_ns()
        return None if shown is None or now_ns is None or now_ns >= shown.until_ns else shown

    def visit(self) -> Visit | None:
        """The visit under way, or the next one."""
        return next(iter(self.memory.open_visits()), None)

    def visit_here(self) -> Visit | None:
        """The visit whose riders may use the doors now; None at a temporary stop."""
        return None if self.temporary is not None else self.visit()

    def target_s_m(self) -> float | None:
        """Where on the line the next visit or temporary stop is; None without one."""
        if self.route is None:
            return None
        if self.temporary is not None:
            return self.temporary.s_m
        visit = self.visit()
        return None if visit is None else self.route.visit_s(visit.visit_id)

    def after(self, *events: VehicleEvent, **changes: object) -> "MissionState":
        """The state with more events and changed fields."""
        return msgspec.structs.replace(self, events=self.events + events, **changes)
