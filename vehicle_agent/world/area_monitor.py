"""Who is in an observation area, and likely to cross what lies before us (Snow Lion, unprotected
intersections; NUS, infrastructure sensors)."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2
from contract.roads.areas import inside, outline_array
from contract.roads.model import ObservationArea
from vehicle_agent.signals import PedestrianPresence, Predictions, Tracks, WatchedArea


class AreaMonitor(msgspec.Struct, frozen=True):
    """near_m    areas nearer to the vehicle than this are watched
    soon_s      who comes into the area within this time counts
    moving_mps  who stands is an obstacle, no crossing traffic
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
    ) -> tuple[WatchedArea, ...]:
        """Every area near the vehicle, in map order; outlines (n, 2) each, in the areas' order."""
        reported = {word.area_id for word in presence if word.count > 0}
        soon = [0]
        if len(predictions.times_s) > 1:
            soon = [int(i) for i in np.flatnonzero(predictions.times_s <= self.soon_s)[::2]]
        speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
        found = []
        for area, outline in zip(areas, outlines, strict=True):
            low, high = outline.min(axis=0), outline.max(axis=0)
            off_x = max(low[0] - pose_map.x_m, 0.0, pose_map.x_m - high[0])
            off_y = max(low[1] - pose_map.y_m, 0.0, pose_map.y_m - high[1])
            if math.hypot(off_x, off_y) > self.near_m:
                continue
            comes = np.zeros(len(tracks.ids), np.bool_)
            for i in soon:
                places = np.ascontiguousarray(predictions.poses_map[:, i, :2])
                comes |= inside(outline, places)
            comes &= speeds >= self.moving_mps
            ids = tuple(int(number) for number in tracks.ids[comes])
            found.append(WatchedArea(area.area_id, ids, area.area_id in reported))
        return tuple(found)


def outlines_of(areas: tuple[ObservationArea, ...]) -> tuple[Array, ...]:
    """Each area's corners as an array."""
    return tuple(outline_array(area) for area in areas)
