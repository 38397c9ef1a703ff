"""What a scripted shuttle says that it sees and plans."""

import math

from contract.wire.messages import LimitAhead, OnboardScene, PathTimes, PathTrack, RoomTime, TickTimes

KNOTS = 41
DT_S = 0.2


def a_scene(stamp_ns: int, x_m: float = 0.0, y_m: float = 0.0) -> OnboardScene:
    """It gives way to one person who crosses 9 m ahead; cells in a ring around (x_m, y_m)."""
    ring = [(x_m + 6.0 * math.cos(k / 8.0), y_m + 6.0 * math.sin(k / 8.0)) for k in range(50)]
    way_m = tuple(round(min(3.0 * DT_S * k, 7.0), 2) for k in range(KNOTS))
    crossing = tuple(range(10, 30))
    return OnboardScene(
        epoch=0,
        stamp_ns=stamp_ns,
        points=tuple(round(value, 2) for point in ring for value in point),
        points_age_s=0.1,
        limited_by="obstacle",
        speed_mps_planned=2.5,
        guard="somebody alongside",
        path_times=PathTimes(
            age_s=0.1,
            dt_s=DT_S,
            way_m=way_m,
            low_m=(None,) * KNOTS,
            high_m=tuple(8.0 if k in crossing else None for k in range(KNOTS)),
            tracks=(
                PathTrack(7, True, crossing, (8.4,) * len(crossing), (10.0,) * len(crossing)),
                PathTrack(9, False, (2, 3), (1.0, 1.0), (2.0, 2.5)),
            ),
            limits=(LimitAhead(0.0, 12.0, 4.0, "speed_limit"), LimitAhead(12.0, 20.0, 1.5, "curve")),
        ),
        tick_times=TickTimes((RoomTime("planning", 2400), RoomTime("perception", 900)), 4100, 350),
    )
