"""The pairs and triples of scans that are compared with the unit's samples."""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from workshop.motion_calibration.drive import InertialDrive, LidarMotion

# A scan that is farther than this share of the span from where it should be is not taken.
_OFF_RATIO = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """Indices of scans: pairs (n, 2) whose turns are compared, triples (m, 3) whose accelerations are."""

    pairs: np.ndarray
    triples: np.ndarray


def windows_of(
    lidar: LidarMotion, unit: InertialDrive, offset_s: float, turn_s: float, half_s: float, margin_s: float
) -> Windows:
    """All windows without a gap in either recording.

    offset_s  of the clocks, right to margin_s: windows so near to the samples' ends are left out
    turn_s    between the two scans of a pair; half_s: between the neighbours of a triple
    """
    at_s = lidar.stamps_s + 1e-9 * lidar.start_ns
    samples_s = unit.stamps_s + (1e-9 * unit.start_ns + offset_s)
    inside = (at_s >= samples_s[0] + margin_s) & (at_s <= samples_s[-1] - margin_s)
    gaps = unit.gaps[np.clip(np.searchsorted(samples_s, at_s), 0, len(samples_s) - 1)]
    pieces = lidar.pieces + gaps
    count = len(at_s)
    first = np.arange(count)
    second, is_second = _after(lidar.stamps_s, turn_s)
    middle, is_middle = _after(lidar.stamps_s, half_s)
    third, is_third = middle[middle], is_middle & is_middle[middle]
    paired = is_second & inside & inside[second] & (pieces == pieces[second])
    tripled = is_third & inside & inside[third] & (pieces == pieces[third])
    return Windows(np.column_stack((first, second))[paired], np.column_stack((first, middle, third))[tripled])


def _after(stamps_s: Array, span_s: float) -> tuple[np.ndarray, np.ndarray]:
    """(index (n,) of the scan nearest to span_s later, whether it is near enough (n,))."""
    wanted = stamps_s + span_s
    right = np.clip(np.searchsorted(stamps_s, wanted), 1, len(stamps_s) - 1)
    left_is_nearer = wanted - stamps_s[right - 1] < stamps_s[right] - wanted
    index = right - left_is_nearer
    return index, np.abs(stamps_s[index] - wanted) <= _OFF_RATIO * span_s
