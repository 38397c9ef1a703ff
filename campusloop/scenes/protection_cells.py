"""Car-to-pedestrian and car-to-cyclist cells after the consumer tests: crossing, running, an occluded child,
turning, longitudinal, by day and by night. Without braking, each ends in a contact at a given share of the
front's width."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import msgspec
import numpy as np

from campusloop.scenes.drive import Scene
from campusloop.scenes.path_map import path_map
from contract.geometry import Array, arc_lengths, pose_at
from simulator.sensors.tracker import TrackerNoise
from simulator.traffic.recordings import Clip, RecordedTrack
from simulator.traffic.replayed import ReplayedTraffic
from simulator.traffic.scripted_clips import CHILD_SIZE_M, SIZES_M, clip_of, standing, walker
from simulator.world import WorldOptions
from vehicle_agent.config import Body, Profile
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

KMH = 1.0 / 3.6
SPEEDS_KMH = (5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0)
SHARES = (0.25, 0.5, 0.75)
RANGES_M = {"day": 45.0, "night": 20.0}
BEFORE_S = 5.0
_RUN_UP_M, _RUN_OUT_M = 14.0, 40.0
_TARGET, _PARKED = 1, 100
# From the parked cars' side to the vehicle's, as in the consumer tests: a lane's width between them.
_PARKED_GAPS_M = (1.0, 1.5)
# The child waits behind the parked cars, where it cannot be seen.
_HIDDEN_M = 5.0


@dataclass(frozen=True, slots=True)
class Cell:
    """path (n, 2): of the rear axle; meet_s_m: the rear axle's position at the contact without braking."""

    name: str
    kind: str
    light: str
    speed_mps: float
    path: Array
    start_s_m: float
    meet_s_m: float
    clip: Clip

    def scene(self, profile: Profile, seed: int) -> Scene:
        """The shuttle drives towards the contact at the cell's speed, which is also its speed limit."""
        limits = msgspec.structs.replace(profile.limits, speed_mps_max=self.speed_mps)
        return Scene(
            name=self.name,
            road_map=path_map(self.name, self.path, width_m=3.5, speed_limit_mps=self.speed_mps),
            profile=msgspec.structs.replace(profile, limits=limits),
            start_s_m=self.start_s_m,
            start_mps=self.speed_mps,
            goal_s_m=self.meet_s_m + 10.0,
            limit_s=(self.meet_s_m - self.start_s_m) / self.speed_mps + 20.0,
            seed=seed,
            actors=ReplayedTraffic(self.clip, 0.0),
            options=WorldOptions(traffic=None, tracker=TrackerNoise(range_m_max=RANGES_M[self.light])),
        )


def cells(body: Body) -> Iterator[Cell]:
    """All cells, in a fixed order."""
    for light in RANGES_M:
        for speed_kmh in SPEEDS_KMH:
            speed_mps = speed_kmh * KMH
            yield from _crossing(body, light, speed_mps)
            yield from _occluded(body, light, speed_mps)
            yield from _longitudinal(body, light, speed_mps)
            if speed_kmh <= 15.0:
                yield from _turning(body, light, speed_mps)


def _straight(speed_mps: float) -> tuple[Array, float, float]:
    """(path, start, position of the contact): the vehicle drives along x."""
    meet_s_m = _RUN_UP_M + speed_mps * BEFORE_S
    x = np.arange(0.0, meet_s_m + _RUN_OUT_M, 1.0)
    path: Array = np.column_stack((x, np.zeros(len(x))))
    return path, _RUN_UP_M, meet_s_m


def _crossing(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """Adults who walk and run, and cyclists, from either side."""
    crossers = (
        ("walks", PEDESTRIAN, 5.0),
        ("runs", PEDESTRIAN, 8.0),
        ("cycles", CYCLIST, 15.0),
        ("cycles-fast", CYCLIST, 20.0),
    )
    for motion, kind, target_kmh in crossers:
        for side, side_name in ((-1.0, "near"), (1.0, "far")):
            for share in SHARES:
                path, start, meet = _straight(speed_mps)
                track = _crosser(body, path, meet, side, share, kind, target_kmh * KMH)
                yield Cell(
                    f"{light}-{motion}-{side_name}-{share:.2f}-{speed_mps / KMH:.1f}",
                    f"crossing {motion}",
                    light,
                    speed_mps,
                    path,
                    start,
                    meet,
                    clip_of("cell", (track,)),
                )


def _crosser(
    body: Body,
    path: Array,
    meet_s_m: float,
    side: float,
    share: float,
    kind: int,
    target_mps: float,
    size_m: tuple[float, float] | None = None,
    way_m_max: float = 25.0,
) -> RecordedTrack:
    """A target that crosses the path at a right angle and is at `share` of the front's width at the contact.

    share is measured from the side that the target comes from. The target stands until it has to walk
    way_m_max to the contact.
    """
    s = arc_lengths(path)
    x_m, y_m, yaw_rad = pose_at(path, s, meet_s_m)
    length_m = (size_m or SIZES_M[kind])[0]
    ahead_m = body.front_overhang_m + 0.5 * (size_m or SIZES_M[kind])[1]
    front = np.array([x_m + ahead_m * math.cos(yaw_rad), y_m + ahead_m * math.sin(yaw_rad)])
    left = np.array([-math.sin(yaw_rad), math.cos(yaw_rad)])
    offset_m = side * (0.5 - share) * body.width_m
    met = front + offset_m * left
    way_m = min(target_mps * BEFORE_S, way_m_max)
    begins_s = BEFORE_S - way_m / target_mps
    begin = met + side * way_m * left
    end = met - side * (8.0 + length_m) * left
    places = ((float(begin[0]), float(begin[1])), (float(end[0]), float(end[1])))
    return walker(_TARGET, kind, places, target_mps, begins_s, size_m)


def _occluded(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """A child runs out between parked cars on the near side."""
    for target_kmh in (5.0, 8.0):
        for gap_m in _PARKED_GAPS_M:
            for share in SHARES:
                path, start, meet = _straight(speed_mps)
                size_m = CHILD_SIZE_M
                child = _crosser(
                    body, path, meet, -1.0, share, PEDESTRIAN, target_kmh * KMH, size_m, _HIDDEN_M
                )
                child_x_m = meet + body.front_overhang_m + 0.5 * size_m[1]
                aside_m = -(0.5 * body.width_m + gap_m + 0.9)
                # The last parked car ends half a metre before the child's path; the next stands behind it.
                parked = (
                    standing(_PARKED, VEHICLE, child_x_m - 0.5 - 2.25, aside_m),
                    standing(_PARKED + 1, VEHICLE, child_x_m - 0.5 - 2.25 - 5.5, aside_m),
                )
                yield Cell(
                    f"{light}-child-{target_kmh:.0f}-{gap_m:.1f}-{share:.2f}-{speed_mps / KMH:.1f}",
                    "occluded child",
                    light,
                    speed_mps,
                    path,
                    start,
                    meet,
                    clip_of("cell", (child, *parked)),
                )


def _longitudinal(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """Targets ahead: standing, in the same direction, and oncoming."""
    targets = (
        ("stands", PEDESTRIAN, 0.0),
        ("walks-ahead", PEDESTRIAN, 5.0),
        ("comes", PEDESTRIAN, -5.0),
        ("cycles-ahead", CYCLIST, 10.0),
    )
    for motion, kind, target_kmh in targets:
        for share in (0.25, 0.5):
            target_mps = target_kmh * KMH
            if target_mps > 0.8 * speed_mps:
                continue
            path, start, meet = _straight(speed_mps)
            front_m = meet + body.front_overhang_m + 0.5 * SIZES_M[kind][0]
            y_m = -(0.5 - share) * body.width_m
            begin_m = front_m - target_mps * BEFORE_S
            if target_mps == 0.0:
                track = standing(_TARGET, kind, begin_m, y_m)
            else:
                ahead_m = begin_m + math.copysign(100.0, target_mps)
                track = walker(_TARGET, kind, ((begin_m, y_m), (ahead_m, y_m)), abs(target_mps))
            yield Cell(
                f"{light}-{motion}-{share:.2f}-{speed_mps / KMH:.1f}",
                f"longitudinal {motion}",
                light,
                speed_mps,
                path,
                start,
                meet,
                clip_of("cell", (track,)),
            )


def _turning(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """The vehicle turns into a road that a pedestrian crosses."""
    for way, radius_m in (("left", 8.0), ("right", -8.0)):
        path, turn_end_m = _turn(radius_m)
        meet = turn_end_m + 1.0
        # The run starts on the straight part, before the turn.
        start = max(2.0, min(meet - speed_mps * BEFORE_S, _STRAIGHT_M - 6.0))
        for motion, target_kmh in (("walks", 5.0), ("runs", 8.0)):
            for side, side_name in ((-1.0, "near"), (1.0, "far")):
                for share in SHARES:
                    track = _crosser(body, path, meet, side, share, PEDESTRIAN, target_kmh * KMH)
                    late_s = (meet - start) / speed_mps - BEFORE_S
                    yield Cell(
                        f"{light}-turn-{way}-{motion}-{side_name}-{share:.2f}-{speed_mps / KMH:.1f}",
                        f"turning {motion}",
                        light,
                        speed_mps,
                        path,
                        start,
                        meet,
                        clip_of("cell", (_shifted(track, late_s),)),
                    )


_STRAIGHT_M = 30.0


def _turn(radius_m: float) -> tuple[Array, float]:
    """(path, position of the turn's end): straight, a quarter circle with eased ends, straight."""
    step, points, yaw, x, y = 0.25, [], 0.0, 0.0, 0.0
    straight_m, easing_m = _STRAIGHT_M, 4.0
    arc_m = abs(radius_m) * 0.5 * math.pi
    length_m = straight_m + arc_m + easing_m
    for k in range(math.ceil((length_m + _RUN_OUT_M) / step)):
        s = k * step
        into, out = s - straight_m, length_m - s
        share = min(max(min(into / easing_m, out / easing_m, 1.0), 0.0), 1.0)
        points.append((x, y))
        yaw += share / radius_m * step
        x += step * math.cos(yaw)
        y += step * math.sin(yaw)
    return np.array(points), length_m


def _shifted(track: RecordedTrack, by_s: float) -> RecordedTrack:
    """The track by_s later, standing until then. A track that begins before the scene is already moving."""
    times_s, states = track.times_s + by_s, track.states
    if times_s[0] > 0.0:
        still = states[0].copy()
        still[3:] = 0.0
        times_s = np.concatenate(([0.0, max(float(times_s[0]) - 1e-3, 1e-4)], times_s))
        states = np.vstack((still, still, states))
    return RecordedTrack(track.number, track.kind, times_s, states, track.size_m)
