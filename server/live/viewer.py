"""The messages for one screen: what it may see and what is new to it. No I/O.

A viewer remembers only the number of the board's last change that it was told of. Changes in between are
skipped: the newest state wins, and no queue grows. A slow reader calls it less often.
"""

import math
from dataclasses import dataclass

import msgspec

from contract.geometry import wrap_angle
from contract.wire.messages import Status
from server.live.scene import (
    Delta,
    IncidentsScene,
    RideScene,
    Scene,
    SceneBoard,
    Snapshot,
    VehicleFacts,
    VehicleScene,
    VehicleTask,
    changed_since,
)

# A screen that receives no message for longer closes the connection and connects again.
HEARTBEAT_MS = 5_000
# A shuttle that stands is told to its passenger so rarely; the report's age is all that changes meanwhile.
STANDING_EVERY_MS = 1_000
# Less than this is the noise of a position at rest, which no screen shows.
_STILL_M, _STILL_RAD = 0.1, 0.03
# Viewers share a message that was made so recently.
SHARED_MS = 20


@dataclass(frozen=True, slots=True)
class EverythingScope:
    """An operator's."""


@dataclass(frozen=True, slots=True)
class RideScope:
    """A passenger's: one ride and the shuttle that has it."""

    ride_id: str


Scope = EverythingScope | RideScope


class Viewer:
    """Gives the next message whenever the connection can take one."""

    def __init__(self, scope: Scope) -> None:
        self._scope = scope
        self._map_version: str | None = None
        self._change = 0
        self._vehicle_id = ""
        self._told: VehicleScene | None = None
        self._incidents = IncidentsScene()
        self._spoke_ms = 0

    def next_message(self, board: SceneBoard, now_ms: int) -> Snapshot | Delta | None:
        """A snapshot first and after a change of map, then deltas; None when nothing changed.

        After HEARTBEAT_MS without a change comes a delta of the time alone.
        """
        message = self._news_since(board, now_ms)
        if message is None and now_ms - self._spoke_ms >= HEARTBEAT_MS:
            message = Delta(now_ms)
        if message is not None:
            self._spoke_ms = now_ms
        return message

    def _news_since(self, board: SceneBoard, now_ms: int) -> Snapshot | Delta | None:
        if self._map_version != board.map_version or not board.knows_all_since(self._change):
            message: Snapshot | Delta | None = self._snapshot(board, now_ms)
        elif isinstance(self._scope, EverythingScope):
            message = everything_since(board, self._change, self._incidents, now_ms)
        else:
            message = self._ride_since(board, self._scope, now_ms)
        self._map_version, self._change = board.map_version, board.change
        if isinstance(self._scope, EverythingScope):
            self._incidents = board.incidents
        return message

    def _snapshot(self, board: SceneBoard, now_ms: int) -> Snapshot:
        if isinstance(self._scope, EverythingScope):
            return Snapshot(
                Scene(
                    at_ms=now_ms,
                    campus_id=board.campus_id,
                    map_version=board.map_version,
                    vehicles=tuple(board.vehicles[key][1] for key in sorted(board.vehicles)),
                    rides=tuple(board.rides[key][1] for key in sorted(board.rides)),
                    incidents=board.incidents,
                    areas=tuple(board.areas[key][1] for key in sorted(board.areas)),
                )
            )
        _, ride, _, vehicle = _of_ride(board, self._scope)
        self._vehicle_id = "" if vehicle is None else vehicle.vehicle_id
        self._told = vehicle
        return Snapshot(
            Scene(
                at_ms=now_ms,
                campus_id=board.campus_id,
                map_version=board.map_version,
                vehicles=() if vehicle is None else (vehicle,),
                rides=() if ride is None else (ride,),
            )
        )

    def _ride_since(self, board: SceneBoard, scope: RideScope, now_ms: int) -> Delta | None:
        """The ride and its shuttle, as far as they are new to its passenger."""
        ride_number, ride, number, vehicle = _of_ride(board, scope)
        before, self._vehicle_id = self._vehicle_id, "" if vehicle is None else vehicle.vehicle_id
        is_new = vehicle is not None and (
            before != self._vehicle_id or (number > self._change and _is_news(self._told, vehicle))
        )
        if is_new:
            self._told = vehicle
        delta = Delta(
            at_ms=now_ms,
            vehicles=(vehicle,) if vehicle is not None and is_new else (),
            vehicles_gone=(before,) if before and before != self._vehicle_id else (),
            rides=(ride,) if ride is not None and ride_number > self._change else (),
            rides_gone=tuple(key for key in board.rides_gone_since(self._change) if key == scope.ride_id),
        )
        return None if delta == Delta(now_ms) else delta


def _is_news(told: VehicleScene | None, vehicle: VehicleScene) -> bool:
    """Whether a passenger has to hear of it now: it moves, or another thing changed, or a second is over."""
    if told is None or vehicle.heard_ms - told.heard_ms >= STANDING_EVERY_MS:
        return True
    known, status = told.status, vehicle.status
    if known is None or status is None:
        return True
    before, pose = known.pose_map, status.pose_map
    if math.hypot(pose.x_m - before.x_m, pose.y_m - before.y_m) >= _STILL_M:
        return True
    if abs(wrap_angle(pose.yaw_rad - before.yaw_rad)) >= _STILL_RAD:
        return True
    same_place = msgspec.structs.replace(status, pose_map=before)
    return msgspec.structs.replace(vehicle, status=same_place, heard_ms=told.heard_ms) != told


def everything_since(board: SceneBoard, change: int, incidents: IncidentsScene, now_ms: int) -> Delta | None:
    """What has changed after that change, for a viewer of everything; None for nothing.

    Viewers that were told of the same change at the same time get the same object.
    """
    if board.change == change and board.incidents == incidents:
        return None
    asked = (change, board.change, incidents, board.incidents)
    known = board.last_delta
    if known is None or known[0] != asked or now_ms - known[1].at_ms > SHARED_MS:
        known = board.last_delta = (asked, _delta_since(board, change, incidents, now_ms))
    return known[1]


def _delta_since(board: SceneBoard, change: int, incidents: IncidentsScene, now_ms: int) -> Delta:
    return Delta(
        at_ms=now_ms,
        vehicles=changed_since(board.vehicles, change),
        vehicles_gone=board.vehicles_gone_since(change),
        rides=changed_since(board.rides, change),
        rides_gone=board.rides_gone_since(change),
        incidents=board.incidents if board.incidents != incidents else None,
        areas=changed_since(board.areas, change),
    )


def _of_ride(board: SceneBoard, scope: RideScope) -> tuple[int, RideScene | None, int, VehicleScene | None]:
    """The ride and its shuttle as its passenger sees them, each with the number of its last change."""
    held = board.rides.get(scope.ride_id)
    if held is None:
        return 0, None, 0, None
    number, ride = held
    shuttle = None if ride.state in _WITHOUT_SHUTTLE else board.vehicles.get(ride.vehicle_id)
    if shuttle is None:
        return number, ride, 0, None
    return number, ride, shuttle[0], _for_passenger(shuttle[1], ride)


# After the ride has ended, its passenger no longer sees the shuttle.
_WITHOUT_SHUTTLE = frozenset({"completed", "refused", "cancelled", "no_show", "failed"})


def _for_passenger(vehicle: VehicleScene, ride: RideScene) -> VehicleScene:
    """A shuttle as a passenger sees it: where it is, its mode and HMI output. Whatever else it reports stays
    with the operators: other rides, faults, commands, and why it is held. Since when and until when it
    stands is told."""
    facts, task = vehicle.facts, vehicle.task
    return VehicleScene(
        vehicle.vehicle_id,
        VehicleFacts(
            facts.name,
            facts.seats,
            facts.wheelchair_places,
            facts.connected,
            facts.held,
            facts.in_service,
            mode=facts.mode,
        ),
        VehicleTask(
            task.next_stop,
            task.people_aboard,
            route=task.route,
            hold_ends_ms=task.hold_ends_ms,
            unavailable_since_ms=task.unavailable_since_ms,
        ),
        None if vehicle.status is None else _status_for_passenger(vehicle.status, ride),
        vehicle.heard_ms,
    )


def _status_for_passenger(status: Status, ride: RideScene) -> Status:
    return Status(
        epoch=0,
        stamp_ns=0,
        pose_map=status.pose_map,
        speed_mps=status.speed_mps,
        accel_mps2=0.0,
        steer_rad=0.0,
        mode=status.mode,
        battery_ratio=0.0,
        doors_open=status.doors_open,
        lane_id="",
        s_m=0.0,
        order_id="",
        revision=0,
        visit_id=status.visit_id,
        aboard=tuple(ride_id for ride_id in status.aboard if ride_id == ride.ride_id),
        screen=status.screen,
        spoken=status.spoken,
    )
