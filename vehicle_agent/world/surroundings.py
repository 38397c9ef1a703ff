"""What the vehicle must respect: obstacles that are no fleet mates, and the fleet mates themselves."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, inverse, transform_points
from vehicle_agent.signals import (
    Detections,
    Ego,
    FleetVehicle,
    Infrastructure,
    PedestrianPresence,
    World,
)
from vehicle_agent.signals.rates import FLEET_VEHICLE_AGE_NS_MAX, PRESENCE_AGE_NS_MAX


class SurroundingsState(msgspec.Struct, frozen=True):
    """What the world model remembers: the latest word on each fleet mate and crossing, and its last sorting.

    sorted_points  the obstacles of `sorted_ns` without those that are a fleet mate
    """

    others: tuple[FleetVehicle, ...]
    presence: tuple[PedestrianPresence, ...]
    sorted_ns: int
    sorted_points: np.ndarray


class Surroundings(msgspec.Struct, frozen=True):
    """Fleet mates have this vehicle's outline; returns within `mate_margin_m` of it are theirs."""

    body_front_m: float
    body_back_m: float
    body_half_width_m: float
    mate_margin_m: float = 0.4
    other_age_ns_max: int = FLEET_VEHICLE_AGE_NS_MAX
    presence_age_ns_max: int = PRESENCE_AGE_NS_MAX

    def initial(self) -> SurroundingsState:
        return SurroundingsState((), (), 0, np.empty((0, 2)))

    def step(
        self,
        state: SurroundingsState,
        ego: Ego,
        seen: Detections,
        infrastructure: tuple[Infrastructure, ...],
        now_ns: int,
    ) -> tuple[World, SurroundingsState]:
        """Fleet mates are carried along their heading to `now_ns`; those not heard of lately are dropped."""
        others = {other.vehicle_id: other for other in state.others}
        presence = {word.area_id: word for word in state.presence}
        for word in infrastructure:
            if isinstance(word, FleetVehicle):
                others[word.vehicle_id] = word
            else:
                _keep_newer(presence, word, now_ns)
        heard = tuple(
            others[name] for name in sorted(others) if now_ns - others[name].stamp_ns <= self.other_age_ns_max
        )
        present = tuple(
            presence[name]
            for name in sorted(presence)
            if now_ns - presence[name].stamp_ns <= self.presence_age_ns_max
        )
        points = state.sorted_points
        if seen.stamp_ns != state.sorted_ns:
            points = self._without(seen.points_map, [_carried(other, seen.stamp_ns) for other in heard])
        world = World(
            stamp_ns=now_ns,
            detections_stamp_ns=seen.stamp_ns,
            points_map=points,
            fleet_vehicles=tuple(_carried(other, now_ns) for other in heard),
            presence=present,
            blind=seen.blind,
            tracks=seen.tracks,
        )
        return world, SurroundingsState(heard, present, seen.stamp_ns, points)

    def _without(self, points_map: Array, mates: list[FleetVehicle]) -> Array:
        keep = np.ones(len(points_map), np.bool_)
        margin_m = self.mate_margin_m
        for mate in mates:
            points = transform_points(inverse(mate.pose_map), points_map)
            keep &= ~(
                (points[:, 0] >= -self.body_back_m - margin_m)
                & (points[:, 0] <= self.body_front_m + margin_m)
                & (np.abs(points[:, 1]) <= self.body_half_width_m + margin_m)
            )
        remaining: Array = points_map[keep]
        return remaining


def _keep_newer(presence: dict[str, PedestrianPresence], word: PedestrianPresence, now_ns: int) -> None:
    """The cloud and the local link tell the same: what was seen last counts, whichever way it came.

    A stamp of the future, of clocks that do not agree, must not outlive its time: it is taken for now.
    """
    word = PedestrianPresence(min(word.stamp_ns, now_ns), word.area_id, word.count)
    known = presence.get(word.area_id)
    if known is None or word.stamp_ns >= known.stamp_ns:
        presence[word.area_id] = word


def _carried(other: FleetVehicle, now_ns: int) -> FleetVehicle:
    """The fleet mate where it is by now, if it has gone on straight at its speed."""
    along_m = other.speed_mps * (now_ns - other.stamp_ns) * 1e-9
    pose = other.pose_map
    moved = Pose2(
        pose.x_m + along_m * math.cos(pose.yaw_rad), pose.y_m + along_m * math.sin(pose.yaw_rad), pose.yaw_rad
    )
    return FleetVehicle(now_ns, other.vehicle_id, moved, other.speed_mps)
