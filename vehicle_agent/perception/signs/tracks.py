"""Signs from scan to scan: kept in the map frame until the vehicle has passed them, and named by evidence."""

import math
from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, inverse, transform_points, wrap_angle
from vehicle_agent.perception.signs.evidence import (
    Evidence,
    likely_size_m,
    no_evidence,
    probabilities,
    with_chords,
)
from vehicle_agent.signals import SeenSign, SignPercept

SignName = Literal["stop", "yield", "board", "other"]


class SignTrack(msgspec.Struct, frozen=True):
    """One board: place and facing in the map, and what speaks for each outline.

    x_m, y_m, yaw_rad  means over the scans, nearer ones weigh more; weight: the sum of the weights
    range_m            at which it was seen last
    scans              in which it was seen
    low_m, high_m      heights between which chords were seen
    """

    sign_id: int
    x_m: float
    y_m: float
    yaw_rad: float
    weight: float
    range_m: float
    scans: int
    evidence: Evidence
    name: SignName = "board"
    low_m: float = math.inf
    high_m: float = -math.inf


class SignsState(msgspec.Struct, frozen=True):
    """The known boards, the stamp of the last percept, and the next id."""

    tracks: tuple[SignTrack, ...] = ()
    stamp_ns: int = 0
    next_id: int = 1


class SignTracker(msgspec.Struct, frozen=True):
    """Parameters of tracks and of their names.

    near_m, turned_rad  a board within these of a known one is that one
    scans_min     before a sign is named
    beyond_chords_m, span_m_min  a stop sign may be higher by this than where its chords were seen: a low wide
                  plate is not taken for an octagon's middle; a yield sign's chords lie this far apart
    sure, unsure  it gets a name at this probability, and loses it below the other; other: it is "other" when
                  stop and yield together are less probable
    behind_m, away_m  a sign this far behind the vehicle, or this far away, is forgotten
    place_m       driven between two scans of full weight: from one place they say the same
    standing_weight  of a scan from the same place
    weight        of a scan of full weight: its errors are not independent of the last one's
    uneven_m      a chord whose middle is farther from the sign's axis was cut by the upper or lower edge
    drift_ratio   see `with_chords`
    tracks_max    the nearest boards are kept
    """

    near_m: float = 1.2
    turned_rad: float = 0.8
    scans_min: int = 4
    beyond_chords_m: float = 0.36
    span_m_min: float = 0.2
    sure: float = 0.8
    unsure: float = 0.5
    other: float = 0.02
    behind_m: float = 12.0
    away_m: float = 45.0
    place_m: float = 0.3
    standing_weight: float = 0.01
    weight: float = 0.5
    uneven_m: float = 0.1
    drift_ratio: float = 0.1
    tracks_max: int = 16

    def step(self, state: SignsState, percept: SignPercept, pose_map: Pose2) -> SignsState:
        """The signs after a percept; pose_map: the vehicle's pose at the percept's stamp."""
        tracks = list(state.tracks)
        next_id = state.next_id
        taken: set[int] = set()
        boards = percept.boards_base[_is_plausible(percept.boards_base)]
        numbers = np.flatnonzero(_is_plausible(percept.boards_base))
        places = transform_points(pose_map, boards[:, :2])
        for number, board, place in zip(numbers, boards, places, strict=True):
            chords = percept.chords[percept.owners == number]
            yaw = wrap_angle(float(board[3]) + pose_map.yaw_rad)
            known = self._nearest(tracks, place, yaw, taken)
            range_m = float(np.hypot(board[0], board[1]))
            if known is None:
                fresh = SignTrack(
                    next_id, float(place[0]), float(place[1]), yaw, 0.0, range_m, 0, no_evidence()
                )
                tracks.append(fresh)
                known, next_id = len(tracks) - 1, next_id + 1
            taken.add(known)
            tracks[known] = self._named(self._seen(tracks[known], place, yaw, range_m, chords))
        kept = [track for track in tracks if self._stays(track, pose_map)]
        kept.sort(key=lambda track: math.hypot(track.x_m - pose_map.x_m, track.y_m - pose_map.y_m))
        return SignsState(tuple(kept[: self.tracks_max]), percept.stamp_ns, next_id)

    def _nearest(self, tracks: list[SignTrack], place: Array, yaw: float, taken: set[int]) -> int | None:
        near = [
            (math.hypot(track.x_m - place[0], track.y_m - place[1]), i)
            for i, track in enumerate(tracks)
            if i not in taken and abs(wrap_angle(track.yaw_rad - yaw)) <= self.turned_rad
        ]
        distance_m, i = min(near, default=(math.inf, 0))
        return i if distance_m <= self.near_m else None

    def _seen(self, track: SignTrack, place: Array, yaw: float, range_m: float, chords: Array) -> SignTrack:
        weight = 1.0 / max(1.0, range_m) ** 2
        share = weight / (track.weight + weight)
        gained = min(1.0, abs(track.range_m - range_m) / self.place_m)
        if track.scans < self.scans_min:
            gained = 1.0
        evidence = track.evidence
        if track.scans >= self.scans_min:
            # A scan of one chord does not tell itself whether a ring grazed the board's edge.
            right = np.array([math.sin(track.yaw_rad), -math.cos(track.yaw_rad)])
            aside_m = float((place - np.array([track.x_m, track.y_m])) @ right)
            chords = chords[np.abs(chords[:, 4] + aside_m) <= self.uneven_m + chords[:, 3]]
        low_m, high_m = track.low_m, track.high_m
        if len(chords):
            low_m = min(low_m, float(chords[:, 1:3].min()))
            high_m = max(high_m, float(chords[:, 1:3].max()))
            drift = self.drift_ratio * gained if track.scans else 0.0
            evidence = with_chords(evidence, chords, self.weight * max(gained, self.standing_weight), drift)
        return msgspec.structs.replace(
            track,
            x_m=track.x_m + share * (float(place[0]) - track.x_m),
            y_m=track.y_m + share * (float(place[1]) - track.y_m),
            yaw_rad=wrap_angle(track.yaw_rad + share * wrap_angle(yaw - track.yaw_rad)),
            weight=track.weight + weight,
            range_m=range_m,
            scans=track.scans + 1,
            evidence=evidence,
            low_m=low_m,
            high_m=high_m,
        )

    def _named(self, track: SignTrack) -> SignTrack:
        likely = probabilities(track.evidence)
        span_m = track.high_m - track.low_m
        size_m = likely_size_m(track.evidence)
        is_seen = track.scans >= self.scans_min
        for outline, name, least_m in (
            ("octagon", "stop", size_m - self.beyond_chords_m),
            ("point_down", "yield", self.span_m_min),
        ):
            least = self.unsure if track.name == name else self.sure
            if likely[outline] >= least and is_seen and span_m >= least_m:
                return msgspec.structs.replace(track, name=name)
        is_other = likely["octagon"] + likely["point_down"] <= self.other
        return msgspec.structs.replace(track, name="other" if is_other else "board")

    def _stays(self, track: SignTrack, pose_map: Pose2) -> bool:
        ahead = transform_points(inverse(pose_map), np.array([[track.x_m, track.y_m]]))[0]
        return bool(ahead[0] >= -self.behind_m and math.hypot(*ahead) <= self.away_m)


def seen_signs(state: SignsState) -> tuple[SeenSign, ...]:
    """The signs as other rooms take them, nearest first."""
    return tuple(
        SeenSign(track.sign_id, track.name, Pose2(track.x_m, track.y_m, track.yaw_rad), track.range_m)
        for track in state.tracks
    )


def _is_plausible(boards_base: np.ndarray) -> np.ndarray:
    """(n,) finite, and on a campus."""
    finite: np.ndarray = np.isfinite(boards_base).all(axis=1)
    with np.errstate(invalid="ignore"):
        finite &= np.abs(boards_base[:, :3]).max(axis=1, initial=0.0) < 1e3
    return finite
