"""Road users in observation areas, who may cross the way ahead (Snow Lion, unprotected intersections; NUS,
infrastructure sensors)."""

import math
from collections.abc import Collection, Mapping
from types import MappingProxyType

import msgspec
import numpy as np

from contract.geometry import Array, Pose2
from contract.roads.areas import inside, outline_array
from contract.roads.model import ObservationArea
from vehicle_agent.signals import PEDESTRIAN, PedestrianPresence, Predictions, Tracks, WatchedArea

_NOTHING_CLEAR: Mapping[str, int] = MappingProxyType({})


class AreaMonitor(msgspec.Struct, frozen=True):
    """near_m    areas nearer to the vehicle than this are watched
    soon_s      a road user who is predicted to enter the area within this time counts
    moving_mps  a slower road user is an obstacle, not crossing traffic
    """

    near_m: float = 45.0
    soon_s: float = 2.0
    moving_mps: float = 0.4

    def watched(
        self,
        areas: tuple[ObservationArea, ...],
        outlines: tuple[Array, ...],
        pose_map: Pose2,
        tracks: Tracks,
        predictions: Predictions,
        presence: tuple[PedestrianPresence, ...],
        clear_ns: Mapping[str, int] = _NOTHING_CLEAR,
    ) -> tuple[WatchedArea, ...]:
        """The areas near the vehicle, in map order; outlines: (n, 2) each, in the order of `areas`.

        clear_ns: when a camera that is believed saw nobody there, by area
        """
        reported = {report.area_id for report in presence if report.count > 0}
        steps = [0]
        if len(predictions.times_s) > 1:
            steps = [int(i) for i in np.flatnonzero(predictions.times_s <= self.soon_s)[::2]]
        speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
        watched_areas = []
        for area, outline in zip(areas, outlines, strict=True):
            lower, upper = outline.min(axis=0), outline.max(axis=0)
            dx_m = max(lower[0] - pose_map.x_m, 0.0, pose_map.x_m - upper[0])
            dy_m = max(lower[1] - pose_map.y_m, 0.0, pose_map.y_m - upper[1])
            if math.hypot(dx_m, dy_m) > self.near_m:
                continue
            is_coming = np.zeros(len(tracks.ids), np.bool_)
            for i in steps:
                points = np.ascontiguousarray(predictions.poses_map[:, i, :2])
                is_coming |= inside(outline, points)
            is_coming &= speeds >= self.moving_mps
            ids = tuple(int(number) for number in tracks.ids[is_coming])
            free_ns = clear_ns.get(area.area_id, 0)
            outlined = area.outline if free_ns else ()
            watched_areas.append(WatchedArea(area.area_id, ids, area.area_id in reported, free_ns, outlined))
        return tuple(watched_areas)


def with_people(
    areas: tuple[ObservationArea, ...],
    outlines: tuple[Array, ...],
    reporting: Collection[str],
    tracks: Tracks,
) -> frozenset[str]:
    """Ids of the areas with a camera (`reporting`) in which the vehicle tracks somebody, also standing."""
    people = np.ascontiguousarray(tracks.poses_map[tracks.kinds == PEDESTRIAN, :2])
    if not len(people):
        return frozenset()
    return frozenset(
        area.area_id
        for area, outline in zip(areas, outlines, strict=True)
        if area.area_id in reporting and bool(inside(outline, people).any())
    )


def outlines_of(areas: tuple[ObservationArea, ...]) -> tuple[Array, ...]:
    """Each area's corners, (n, 2)."""
    return tuple(outline_array(area) for area in areas)
