"""Targets that cross the vehicle's way: in the open, from behind parked cars, and where the vehicle turns."""

import math
from collections.abc import Iterator

import numpy as np

from campusloop.scenes.protection.cell import (
    BEFORE_S,
    KMH,
    PARKED,
    SCOOTER_SIZE_M,
    SHARES,
    Cell,
    crosser,
    straight,
)
from contract.geometry import Array
from simulator.traffic.recordings import RecordedTrack
from simulator.traffic.scripted_clips import CHILD_SIZE_M, clip_of, standing
from vehicle_agent.config import Body
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

# From the parked cars' side to the vehicle's, as in the consumer tests: a lane's width between them.
PARKED_GAPS_M = (1.0, 1.5)
# The target waits behind the parked cars, where it cannot be seen.
_HIDDEN_M = 5.0
_STRAIGHT_M, _BEYOND_M = 30.0, 40.0


def crossing(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """Adults who walk and run, cyclists and people on scooters, from either side."""
    crossers = (
        ("walks", PEDESTRIAN, 5.0, None),
        ("runs", PEDESTRIAN, 8.0, None),
        ("cycles", CYCLIST, 15.0, None),
        ("cycles-fast", CYCLIST, 20.0, None),
        ("scoots", CYCLIST, 20.0, SCOOTER_SIZE_M),
        ("scoots-fast", CYCLIST, 25.0, SCOOTER_SIZE_M),
    )
    for motion, kind, target_kmh, size_m in crossers:
        for side, side_name in ((-1.0, "near"), (1.0, "far")):
            for share in SHARES:
                path, start, meet = straight(speed_mps)
                track = crosser(body, path, meet, side, share, kind, target_kmh * KMH, size_m)
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


def occluded(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """A child runs out between parked cars on the near side, or somebody on a scooter rides out."""
    hidden = (
        ("child-5", "occluded child", 5.0, PEDESTRIAN, CHILD_SIZE_M),
        ("child-8", "occluded child", 8.0, PEDESTRIAN, CHILD_SIZE_M),
        ("hidden-scooter-15", "occluded scooter", 15.0, CYCLIST, SCOOTER_SIZE_M),
    )
    for name, title, target_kmh, kind, size_m in hidden:
        for gap_m in PARKED_GAPS_M:
            for share in SHARES:
                path, start, meet = straight(speed_mps)
                child = crosser(body, path, meet, -1.0, share, kind, target_kmh * KMH, size_m, _HIDDEN_M)
                child_x_m = meet + body.front_overhang_m + 0.5 * size_m[1]
                aside_m = -(0.5 * body.width_m + gap_m + 0.9)
                # The last parked car ends half a metre before the child's path; the next stands behind it.
                parked = (
                    standing(PARKED, VEHICLE, child_x_m - 0.5 - 2.25, aside_m),
                    standing(PARKED + 1, VEHICLE, child_x_m - 0.5 - 2.25 - 5.5, aside_m),
                )
                yield Cell(
                    f"{light}-{name}-{gap_m:.1f}-{share:.2f}-{speed_mps / KMH:.1f}",
                    title,
                    light,
                    speed_mps,
                    path,
                    start,
                    meet,
                    clip_of("cell", (child, *parked)),
                )


def turning(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """The vehicle turns into a road that a pedestrian crosses."""
    for way, radius_m in (("left", 8.0), ("right", -8.0)):
        path, turn_end_m = _turn(radius_m)
        meet = turn_end_m + 1.0
        # The run starts on the straight part, before the turn.
        start = max(2.0, min(meet - speed_mps * BEFORE_S, _STRAIGHT_M - 6.0))
        for motion, target_kmh in (("walks", 5.0), ("runs", 8.0)):
            for side, side_name in ((-1.0, "near"), (1.0, "far")):
                for share in SHARES:
                    track = crosser(body, path, meet, side, share, PEDESTRIAN, target_kmh * KMH)
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


def _turn(radius_m: float) -> tuple[Array, float]:
    """(path, position of the turn's end): straight, a quarter circle with eased ends, straight."""
    step, points, yaw, x, y = 0.25, [], 0.0, 0.0, 0.0
    straight_m, easing_m = _STRAIGHT_M, 4.0
    arc_m = abs(radius_m) * 0.5 * math.pi
    length_m = straight_m + arc_m + easing_m
    for k in range(math.ceil((length_m + _BEYOND_M) / step)):
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
