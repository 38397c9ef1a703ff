"""Targets in the vehicle's lane ahead of it."""

import math
from collections.abc import Iterator

from campusloop.scenes.protection.cell import BEFORE_S, KMH, SCOOTER_SIZE_M, TARGET, Cell, straight
from simulator.traffic.scripted_clips import SIZES_M, clip_of, standing, walker
from vehicle_agent.config import Body
from vehicle_agent.signals import CYCLIST, PEDESTRIAN


def longitudinal(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """Targets ahead: standing, in the same direction, and oncoming."""
    targets = (
        ("stands", PEDESTRIAN, 0.0, None),
        ("walks-ahead", PEDESTRIAN, 5.0, None),
        ("comes", PEDESTRIAN, -5.0, None),
        ("cycles-ahead", CYCLIST, 10.0, None),
        ("scoots-ahead", CYCLIST, 10.0, SCOOTER_SIZE_M),
        ("cycles-towards", CYCLIST, -15.0, None),
        ("scoots-towards", CYCLIST, -20.0, SCOOTER_SIZE_M),
    )
    for motion, kind, target_kmh, size_m in targets:
        for share in (0.25, 0.5):
            target_mps = target_kmh * KMH
            if target_mps > 0.8 * speed_mps:
                continue
            path, start, meet = straight(speed_mps)
            front_m = meet + body.front_overhang_m + 0.5 * (size_m or SIZES_M[kind])[0]
            y_m = -(0.5 - share) * body.width_m
            begin_m = front_m - target_mps * BEFORE_S
            if target_mps == 0.0:
                track = standing(TARGET, kind, begin_m, y_m)
            else:
                ahead_m = begin_m + math.copysign(100.0, target_mps)
                track = walker(TARGET, kind, ((begin_m, y_m), (ahead_m, y_m)), abs(target_mps), size_m=size_m)
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
