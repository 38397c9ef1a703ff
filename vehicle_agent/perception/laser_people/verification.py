"""Whether tracks of the laser are people: a region of a picture for each (NUS paper, section III-A)."""

from typing import Protocol

import msgspec
import numpy as np

from contract.geometry import Array, Pose2
from vehicle_agent.perception.camera.conditions import CameraCondition, CameraRules
from vehicle_agent.perception.camera.projection import Regions, person_regions, turned_region
from vehicle_agent.perception.laser_people.tracking import LaserTracks, placed_at_base
from vehicle_agent.signals.pictures import Picture, PinholeCamera


class RegionScorer(Protocol):
    """Says how much a region looks like a person; 0.0 is the classifier's plane."""

    def score(self, pixels: np.ndarray, feet_px: tuple[float, float], height_px: float) -> float:
        """As `HogPeopleDetector.score`."""
        ...


class PersonVerification(msgspec.Struct, frozen=True):
    """What a look at a region counts.

    score_even       score at which a region says nothing
    gain             evidence for each unit of score above or below it
    evidence_look    most that one picture counts for; against: at least minus doubt_look
    doubt_look       less than evidence_look, for a person is missed more often than a tree is taken for one
    evidence_label   sum at which a track is a person from then on
    evidence_range   the sum stays within plus and minus this
    person_m         height that regions are cut for; heights: shares of it, one for each look in turn
    speed_mps_max    nothing on foot is faster
    range_m_max      a person farther away has too few pixels
    regions_max      regions of one picture, a budget; unverified tracks come first, then the nearest
    relook_every     a verified track is looked at again in one picture of so many
    turned_max       regions that are looked at upside down, too, to notice a camera that is
    apart_ns_max     pictures that are older or newer than the tracks by more are not used
    """

    score_even: float = 0.0
    score_sure: float = 0.5
    gain: float = 3.0
    evidence_look: float = 1.5
    doubt_look: float = 0.3
    evidence_label: float = 2.4
    evidence_range: float = 6.0
    doubt_range: float = 0.9
    person_m: float = 1.7
    heights: tuple[float, ...] = (1.0, 0.92, 1.08)
    speed_mps_max: float = 4.0
    width_m_min: float = 0.07
    thin_range_m: float = 22.0
    range_m_max: float = 36.0
    regions_max: int = 60
    relook_every: int = 8
    turned_max: int = 1
    apart_ns_max: int = 300_000_000

    def look(
        self,
        tracks: LaserTracks,
        followed: np.ndarray,
        picture: Picture,
        camera: PinholeCamera,
        pose_map: Pose2,
        scorer: RegionScorer,
        condition: CameraCondition,
        rules: CameraRules,
    ) -> tuple[LaserTracks, CameraCondition]:
        """The tracks and the camera's condition after a picture.

        followed   (n,) which tracks count
        pose_map   of the vehicle when the picture was taken
        condition  after this picture; a camera that is not good gives no evidence for or against anything
        """
        places_base = self._places_base(tracks, picture.stamp_ns, pose_map)
        if places_base is None or condition.state not in ("good", "upside_down"):
            return tracks, condition
        regions, rivals, rows = self._asked(tracks, followed, places_base, camera)
        scores = np.full(len(tracks), -np.inf)
        upright = turned = 0
        for number, row in enumerate(rows.tolist()):
            share = self.heights[int(tracks.looks[row]) % len(self.heights)]
            height_px = float(regions.heights_px[row]) * share
            feet_px = (float(regions.feet_px[row, 0]), float(regions.feet_px[row, 1]))
            scores[row] = scorer.score(picture.pixels, feet_px, height_px)
            upright += bool(scores[row] > self.score_sure)
            if number < self.turned_max:
                round_px = turned_region(camera, feet_px, height_px)
                turned += scorer.score(picture.pixels[::-1, ::-1], round_px, height_px) > self.score_sure
        condition = rules.after_regions(condition, upright, turned)
        if condition.state != "good":
            return tracks, condition
        # One person in the picture is one track: of those that overlap there, the surest.
        is_best = scores >= np.where(rivals, scores[None, :], -np.inf).max(axis=1, initial=-np.inf)
        chosen = np.isfinite(scores) & is_best
        weights = self.gain * (scores[chosen] - self.score_even)
        weights = np.clip(weights, -self.doubt_look, self.evidence_look)
        evidence, looks = tracks.evidence.copy(), tracks.looks.copy()
        evidence[chosen] = np.clip(evidence[chosen] + weights, -self.doubt_range, self.evidence_range)
        looks[np.isfinite(scores)] += 1
        is_person = tracks.is_person | (evidence >= self.evidence_label)
        return msgspec.structs.replace(tracks, evidence=evidence, looks=looks, is_person=is_person), condition

    def asked_regions(
        self,
        tracks: LaserTracks,
        followed: np.ndarray,
        stamp_ns: int,
        camera: PinholeCamera,
        pose_map: Pose2,
    ) -> tuple[Array, Array]:
        """(feet_px (k, 2), heights_px (k,)) of what `look` would score in a picture of stamp_ns."""
        places_base = self._places_base(tracks, stamp_ns, pose_map)
        if places_base is None:
            return np.empty((0, 2)), np.empty(0)
        regions, _, rows = self._asked(tracks, followed, places_base, camera)
        return regions.feet_px[rows], max(self.heights) * regions.heights_px[rows]

    def _places_base(self, tracks: LaserTracks, stamp_ns: int, pose_map: Pose2) -> Array | None:
        """(n, 2) where the things were at stamp_ns; None: nothing is followed, or it is too far away."""
        apart_ns = stamp_ns - tracks.stamp_ns
        if not len(tracks) or abs(apart_ns) > self.apart_ns_max:
            return None
        return placed_at_base(tracks.places_map + apart_ns * 1e-9 * tracks.velocities_map_mps, pose_map)

    def _asked(
        self, tracks: LaserTracks, followed: np.ndarray, places_base: Array, camera: PinholeCamera
    ) -> tuple[Regions, np.ndarray, np.ndarray]:
        """(regions of all tracks, (n, n) which overlap, rows that a picture is asked about)."""
        ground = np.column_stack((places_base, np.zeros(len(tracks))))
        regions = person_regions(camera, ground, self.person_m)
        ranges = np.hypot(places_base[:, 0], places_base[:, 1])
        rivals = _overlapping(regions)
        return regions, rivals, self._rows(tracks, followed, regions, ranges, rivals)

    def _rows(
        self, tracks: LaserTracks, followed: np.ndarray, regions: Regions, ranges: Array, rivals: np.ndarray
    ) -> np.ndarray:
        """The tracks that this picture is asked about, in the order of their weight."""
        speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
        is_wide = (tracks.widths_m >= self.width_m_min) | (ranges > self.thin_range_m)
        possible = followed & regions.is_seen & is_wide
        possible &= (speeds <= self.speed_mps_max) & (ranges <= self.range_m_max)
        turn = (tracks.ids + tracks.stamp_ns // 1_000_000) % self.relook_every == 0
        # A verified track is looked at in its turn, and where it could be what a region of another one shows.
        is_rival = (rivals & (possible & ~tracks.is_person)[None, :]).any(axis=1)
        rows = np.flatnonzero(possible & (~tracks.is_person | turn | is_rival))
        order = np.lexsort((ranges[rows], tracks.is_person[rows]))
        return rows[order[: self.regions_max]]


def _overlapping(regions: Regions) -> np.ndarray:
    """(n, n) which other regions could show the same person."""
    u, v, heights = regions.feet_px[:, 0], regions.feet_px[:, 1], regions.heights_px
    reach = 0.08 * heights[:, None] + 0.08 * heights[None, :]
    near: np.ndarray = np.abs(u[:, None] - u[None, :]) < reach
    near &= np.abs(v[:, None] - v[None, :]) < 0.7 * np.maximum(heights[:, None], heights[None, :])
    near &= regions.is_seen[:, None] & regions.is_seen[None, :]
    np.fill_diagonal(near, False)
    return near
