"""Obstacles that are not fleet vehicles, and the fleet vehicles themselves."""

import math
from collections.abc import Mapping
from typing import TypeVar

import msgspec
import numpy as np

from contract.geometry import Array, BoolArray, Pose2, inverse, transform_points
from vehicle_agent.signals import (
    Detections,
    Ego,
    FleetVehicle,
    Infrastructure,
    PedestrianPresence,
    World,
)
from vehicle_agent.signals.rates import FLEET_VEHICLE_AGE_NS_MAX, PRESENCE_AGE_NS_MAX

Report = TypeVar("Report", FleetVehicle, PedestrianPresence)


class SurroundingsState(msgspec.Struct, frozen=True):
    """What the world model remembers: the latest report of each fleet vehicle and observation area.

    filtered_points  the obstacle cells of `filtered_ns` that do not belong to a fleet vehicle
    filtered_low     (n,) which of them are kerbs
    """

    fleet_vehicles: tuple[FleetVehicle, ...]
    presence: tuple[PedestrianPresence, ...]
    filtered_ns: int
    filtered_points: np.ndarray
    filtered_low: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.bool_))


class Surroundings(msgspec.Struct, frozen=True):
    """Fleet vehicles have this vehicle's outline; cells within `fleet_margin_m` of it belong to them."""

    body_front_m: float
    body_back_m: float
    body_half_width_m: float
    fleet_margin_m: float = 0.4
    fleet_age_ns_max: int = FLEET_VEHICLE_AGE_NS_MAX
    presence_age_ns_max: int = PRESENCE_AGE_NS_MAX

    def initial(self) -> SurroundingsState:
        return SurroundingsState((), (), 0, np.empty((0, 2)))

    def step(
        self,
        state: SurroundingsState,
        ego: Ego,
        detections: Detections,
        infrastructure: tuple[Infrastructure, ...],
        now_ns: int,
    ) -> tuple[World, SurroundingsState]:
        """Fleet vehicles are extrapolated along their heading to `now_ns`; old reports are dropped."""
        fleet_vehicles = {vehicle.vehicle_id: vehicle for vehicle in state.fleet_vehicles}
        presence = {message.area_id: message for message in state.presence}
        for message in infrastructure:
            if isinstance(message, FleetVehicle):
                fleet_vehicles[message.vehicle_id] = message
            else:
                _take_newer(presence, message, now_ns)
        recent = _recent(fleet_vehicles, now_ns - self.fleet_age_ns_max)
        recent_presence = _recent(presence, now_ns - self.presence_age_ns_max)
        points, is_low = state.filtered_points, state.filtered_low
        if detections.stamp_ns != state.filtered_ns:
            kept = self._outside_fleet_vehicles(
                detections.points_map, [_extrapolated(vehicle, detections.stamp_ns) for vehicle in recent]
            )
            points = detections.points_map[kept]
            is_low = detections.is_low[kept] if len(detections.is_low) == len(kept) else np.empty(0, np.bool_)
        world = World(
            stamp_ns=now_ns,
            detections_stamp_ns=detections.stamp_ns,
            points_map=points,
            fleet_vehicles=tuple(_extrapolated(vehicle, now_ns) for vehicle in recent),
            presence=recent_presence,
            blind=detections.blind,
            tracks=detections.tracks,
            signs=detections.signs,
            is_low=is_low,
            kerbs_map=detections.kerbs_map,
        )
        return world, SurroundingsState(recent, recent_presence, detections.stamp_ns, points, is_low)

    def _outside_fleet_vehicles(self, points_map: Array, vehicles: list[FleetVehicle]) -> BoolArray:
        """(n,) which cells belong to no fleet vehicle."""
        keep: BoolArray = np.ones(len(points_map), np.bool_)
        margin_m = self.fleet_margin_m
        for vehicle in vehicles:
            points = transform_points(inverse(vehicle.pose_map), points_map)
            keep &= ~(
                (points[:, 0] >= -self.body_back_m - margin_m)
                & (points[:, 0] <= self.body_front_m + margin_m)
                & (np.abs(points[:, 1]) <= self.body_half_width_m + margin_m)
            )
        return keep


def _recent(reports: Mapping[str, Report], since_ns: int) -> tuple[Report, ...]:
    """The reports since a time, in the order of their names."""
    return tuple(reports[name] for name in sorted(reports) if reports[name].stamp_ns >= since_ns)


def _take_newer(presence: dict[str, PedestrianPresence], message: PedestrianPresence, now_ns: int) -> None:
    """Takes a report into `presence` unless a newer one is known: the same report may come over two links.

    A stamp in the future, from clocks that differ, counts as now, so that the report ends in time.
    """
    message = msgspec.structs.replace(message, stamp_ns=min(message.stamp_ns, now_ns))
    known = presence.get(message.area_id)
    if known is None or message.stamp_ns >= known.stamp_ns:
        presence[message.area_id] = message


def _extrapolated(vehicle: FleetVehicle, now_ns: int) -> FleetVehicle:
    """The fleet vehicle at now_ns, straight on at its reported speed."""
    travelled_m = vehicle.speed_mps * (now_ns - vehicle.stamp_ns) * 1e-9
    pose = vehicle.pose_map
    moved_pose = Pose2(
        pose.x_m + travelled_m * math.cos(pose.yaw_rad),
        pose.y_m + travelled_m * math.sin(pose.yaw_rad),
        pose.yaw_rad,
    )
    return FleetVehicle(now_ns, vehicle.vehicle_id, moved_pose, vehicle.speed_mps)
