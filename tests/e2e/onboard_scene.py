"""What a scripted shuttle says that it sees and plans."""

import math

import numpy as np

from contract.geometry import Pose2
from contract.runlog import foxglove
from contract.wire.messages import (
    LimitAhead,
    OnboardScene,
    PathTimes,
    PathTrack,
    RoomTime,
    ShownScan,
    ShownSign,
    ShownTrack,
    TickTimes,
)

KNOTS = 41
DT_S = 0.2


def a_scene(stamp_ns: int, x_m: float = 0.0, y_m: float = 0.0) -> OnboardScene:
    """It gives way to one person who crosses 9 m ahead; cells, road users and signs are around (x_m, y_m)."""
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
        tracks_by="own",
        tracks=(
            ShownTrack(7, "pedestrian", x_m + 9.0, y_m - 2.0, 1.57, 0.5, 0.5, 0.0, 1.4, True),
            ShownTrack(9, "vehicle", x_m - 8.0, y_m + 5.0, 0.3, 4.4, 1.8, 0.0, 0.0),
            ShownTrack(12, "cyclist", x_m + 4.0, y_m + 8.0, 2.5, 1.8, 0.6, -3.0, 2.2),
            ShownTrack(15, "other", x_m - 3.0, y_m - 7.0, 0.0, 0.8, 0.8, 0.0, 0.0),
        ),
        tracks_age_s=0.1,
        signs=(
            ShownSign(1, "stop", x_m + 11.0, y_m + 4.0, 3.1, 11.7),
            ShownSign(2, "board", x_m + 17.0, y_m - 5.0, -2.5, 17.7),
            ShownSign(3, "yield", x_m - 9.0, y_m - 6.0, 0.5, 10.8),
        ),
        scan=ShownScan(x_m, y_m, 0.4, np.rint(100.0 * _wall()).astype("<i2").tobytes()),
    )


def a_scan(utc_ns: int, x_m: float, y_m: float) -> bytes:
    """The same points, as a run log has them: of a vehicle that looked north."""
    wall = _wall()
    points_base = np.column_stack((wall[:, 1], -wall[:, 0], wall[:, 2]))
    return foxglove.scan_cloud(utc_ns, Pose2(x_m, y_m, 0.5 * math.pi), points_base)


def _wall() -> np.ndarray:
    """(160, 3) points of a wall that goes from west to east, 7 m north."""
    along, up = np.meshgrid(np.linspace(-12.0, 12.0, 40), np.linspace(0.5, 2.0, 4))
    return np.column_stack((along.ravel(), np.full(along.size, 7.0), up.ravel()))
