"""The messages for one screen: what it may see and what is new to it. No I/O.

A viewer remembers only the last change of each item that it was given. Changes in between are skipped: the
newest state wins, and no queue grows. A slow reader calls it less often.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

from contract.wire.messages import Status
from server.live.scene import (
    AreaScene,
    Delta,
    IncidentsScene,
    RideScene,
    Scene,
    SceneBoard,
    Snapshot,
    VehicleFacts,
    VehicleScene,
    VehicleTask,
)

T = TypeVar("T")

# A screen that receives no message for longer closes the connection and connects again.
HEARTBEAT_MS = 5_000


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
        self._vehicles: dict[str, int] = {}
        self._rides: dict[str, int] = {}
        self._areas: dict[str, int] = {}
        self._incidents: IncidentsScene | None = None
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
        if self._map_version != board.map_version:
            return self._snapshot(board, now_ms)
        vehicles, rides = self._visible(board)
        incidents = self._visible_incidents(board)
        delta = Delta(
            at_ms=now_ms,
            vehicles=tuple(_news(vehicles, self._vehicles)),
            vehicles_gone=_gone(vehicles, self._vehicles),
            rides=tuple(_news(rides, self._rides)),
            rides_gone=_gone(rides, self._rides),
            incidents=incidents if incidents != self._incidents else None,
            areas=tuple(_news(self._visible_areas(board), self._areas)),
        )
        if delta == Delta(now_ms):
            return None
        self._remember(board, vehicles, rides)
        return delta

    def _snapshot(self, board: SceneBoard, now_ms: int) -> Snapshot:
        vehicles, rides = self._visible(board)
        self._remember(board, vehicles, rides)
        scene = Scene(
            at_ms=now_ms,
            campus_id=board.campus_id,
            map_version=board.map_version,
            vehicles=tuple(vehicle for _, vehicle in vehicles.values()),
            rides=tuple(ride for _, ride in rides.values()),
            incidents=self._visible_incidents(board),
            areas=tuple(area for _, area in self._visible_areas(board).values()),
        )
        return Snapshot(scene)

    def _visible(
        self, board: SceneBoard
    ) -> tuple[dict[str, tuple[int, VehicleScene]], dict[str, tuple[int, RideScene]]]:
        if isinstance(self._scope, EverythingScope):
            return board.vehicles, board.rides
        held = board.rides.get(self._scope.ride_id)
        if held is None:
            return {}, {}
        number, ride = held
        shuttle = None if ride.state in _WITHOUT_SHUTTLE else board.vehicles.get(ride.vehicle_id)
        vehicles = (
            {} if shuttle is None else {ride.vehicle_id: (shuttle[0], _for_passenger(shuttle[1], ride))}
        )
        return vehicles, {ride.ride_id: (number, ride)}

    def _visible_incidents(self, board: SceneBoard) -> IncidentsScene:
        return board.incidents if isinstance(self._scope, EverythingScope) else IncidentsScene()

    def _visible_areas(self, board: SceneBoard) -> dict[str, tuple[int, AreaScene]]:
        return board.areas if isinstance(self._scope, EverythingScope) else {}

    def _remember(
        self,
        board: SceneBoard,
        vehicles: dict[str, tuple[int, VehicleScene]],
        rides: dict[str, tuple[int, RideScene]],
    ) -> None:
        self._map_version = board.map_version
        self._vehicles = {key: number for key, (number, _) in vehicles.items()}
        self._rides = {key: number for key, (number, _) in rides.items()}
        self._areas = {key: number for key, (number, _) in self._visible_areas(board).items()}
        self._incidents = self._visible_incidents(board)


# After the ride has ended, its passenger no longer sees the shuttle.
_WITHOUT_SHUTTLE = frozenset({"completed", "refused", "cancelled", "no_show", "failed"})


def _for_passenger(vehicle: VehicleScene, ride: RideScene) -> VehicleScene:
    """A shuttle as a passenger sees it: where it is, its mode and HMI output. Whatever else it reports stays
    with the operators: other rides, faults, commands, and why it is held."""
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
        VehicleTask(task.next_stop, task.people_aboard, route=task.route),
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


def _news(now: dict[str, tuple[int, T]], sent: dict[str, int]) -> Iterable[T]:
    return (item for key, (number, item) in now.items() if sent.get(key) != number)


def _gone(now: dict[str, tuple[int, T]], sent: dict[str, int]) -> tuple[str, ...]:
    return tuple(key for key in sent if key not in now)
