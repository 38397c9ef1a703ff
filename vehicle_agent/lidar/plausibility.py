"""Whether a scan can be one of a working lidar."""

from typing import Literal

import msgspec
import numpy as np

from vehicle_agent.signals.point_cloud import PointCloud

CloudFaultCode = Literal[
    "empty", "not_finite", "frozen", "saturated", "too_near", "stamp_not_later", "times_unordered"
]


class CloudFault(msgspec.Struct, frozen=True):
    """Something that is wrong with a scan.

    empty            fewer returns than a covered or broken sensor gives
    not_finite       coordinates that are no numbers
    frozen           the same points as in the scan before: noise alone makes every scan different
    saturated        nearly all intensities are the greatest that occurs, and equal
    too_near         nearly all returns are within arm's length: the window is covered
    stamp_not_later  the stamp is not after that of the scan before
    times_unordered  the points' times are before the stamp, or span more than a second
    """

    code: CloudFaultCode
    detail: str


class CloudLimits(msgspec.Struct, frozen=True):
    """Bounds of a scan of a working lidar.

    points_min           returns; an open square gives a sensor of 16 beams several thousand
    share                of the returns that must be alike for `saturated` and `too_near`
    near_m               arm's length
    span_ns_max          of the points' times; the slowest turns take 200 ms
    """

    points_min: int = 100
    share: float = 0.95
    near_m: float = 0.5
    span_ns_max: int = 1_000_000_000


# One intensity alone is what a source without intensities gives, too: it is 0 there.
_SATURATED_MIN = 1e-6


def cloud_faults(
    cloud: PointCloud, before: PointCloud | None = None, limits: CloudLimits | None = None
) -> tuple[CloudFault, ...]:
    """What is wrong with a scan, given the one before it."""
    limits = limits or CloudLimits()
    faults: list[CloudFault] = []
    count = len(cloud)
    finite = np.isfinite(cloud.points_sensor).all(axis=1)
    if count < limits.points_min:
        faults.append(CloudFault("empty", f"{count} returns"))
    if not finite.all():
        faults.append(CloudFault("not_finite", f"{count - int(finite.sum())} of {count} points"))
    if count >= limits.points_min:
        faults += _alike(cloud, finite, limits)
    if before is not None:
        if count and np.array_equal(cloud.points_sensor, before.points_sensor):
            faults.append(CloudFault("frozen", f"the same {count} points as in the scan before"))
        if cloud.stamp_ns <= before.stamp_ns:
            faults.append(
                CloudFault(
                    "stamp_not_later",
                    f"{(before.stamp_ns - cloud.stamp_ns) / 1e6:.1f} ms before the last one",
                )
            )
    if count and not 0 <= cloud.offsets_ns.min() <= cloud.offsets_ns.max() <= limits.span_ns_max:
        low_ms, high_ms = cloud.offsets_ns.min() / 1e6, cloud.offsets_ns.max() / 1e6
        faults.append(CloudFault("times_unordered", f"{low_ms:.1f} to {high_ms:.1f} ms after the stamp"))
    return tuple(faults)


def _alike(cloud: PointCloud, finite: np.ndarray, limits: CloudLimits) -> list[CloudFault]:
    faults: list[CloudFault] = []
    greatest = float(cloud.intensities.max())
    saturated = float(np.mean(cloud.intensities == greatest))
    if greatest > _SATURATED_MIN and saturated >= limits.share:
        faults.append(CloudFault("saturated", f"{100 * saturated:.0f} % of the intensities are {greatest:g}"))
    ranges_m = np.linalg.norm(cloud.points_sensor[finite].astype(np.float64), axis=1)
    near = float(np.mean(ranges_m < limits.near_m)) if len(ranges_m) else 0.0
    if near >= limits.share:
        faults.append(
            CloudFault("too_near", f"{100 * near:.0f} % of the returns are nearer than {limits.near_m} m")
        )
    return faults
