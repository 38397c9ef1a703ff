"""The offset between the clocks of lidar and unit: the drive turns at the same moments in both."""

import numpy as np

from contract.geometry import Array
from workshop.calibration.errors import CalibrationError
from workshop.motion_calibration.drive import InertialDrive, LidarMotion
from workshop.motion_calibration.integration import rotation_vectors

_GRID_S = 0.02
# Over which the lidar's turn rates are taken: a scan's rotation has noise.
_SPAN = 3
# Clocks of the same epoch differ by less; with others every offset is tried.
_SAME_EPOCH_S = 5.0
_OVERLAP_MIN = 0.5
_CORRELATION_MIN = 0.8
# Another offset, farther than this, that fits nearly as well makes it ambiguous.
_OTHER_S, _OTHER_RATIO = 2.0, 0.95


def clock_offset_s(lidar: LidarMotion, unit: InertialDrive) -> float:
    """What has to be added to the unit's stamps to be the lidar's time, to about 20 ms.

    By the correlation of the angular speeds, which no mount changes. CalibrationError if none fits.
    """
    seen = _lidar_speeds(lidar)
    felt = _unit_speeds(unit)
    shifts, correlations = _correlations(seen, felt)
    stated_s = 1e-9 * (unit.start_ns - lidar.start_ns)
    ends_s = (_GRID_S * len(seen), stated_s + _GRID_S * len(felt))
    common_s = min(ends_s) - max(0.0, stated_s)
    offsets_s = _GRID_S * shifts - stated_s
    chosen = np.isfinite(correlations)
    if common_s >= _OVERLAP_MIN * _GRID_S * min(len(seen), len(felt)):
        chosen &= np.abs(offsets_s) <= _SAME_EPOCH_S
    if not chosen.any():
        raise CalibrationError("no_common_time", "scans and samples have too little time in common")
    offsets_s, correlations = offsets_s[chosen], correlations[chosen]
    best = int(np.argmax(correlations))
    if correlations[best] < _CORRELATION_MIN:
        raise CalibrationError(
            "no_common_time",
            f"the unit does not turn when the lidar does (correlation {correlations[best]:.2f}):"
            " are both of the same drive?",
        )
    others = correlations[np.abs(offsets_s - offsets_s[best]) > _OTHER_S]
    if others.size and others.max() > _OTHER_RATIO * correlations[best]:
        raise CalibrationError(
            "ambiguous", "the clocks fit at two offsets alike: drive bends of different lengths"
        )
    return float(offsets_s[best])


def _lidar_speeds(lidar: LidarMotion) -> Array:
    """(n,) rad/s on the grid from the first scan; NaN in gaps."""
    first, last = lidar.poses[:-_SPAN, :3, :3], lidar.poses[_SPAN:, :3, :3]
    spans_s = lidar.stamps_s[_SPAN:] - lidar.stamps_s[:-_SPAN]
    speeds = np.linalg.norm(rotation_vectors(first.transpose(0, 2, 1) @ last), axis=1) / spans_s
    speeds[lidar.pieces[_SPAN:] != lidar.pieces[:-_SPAN]] = np.nan
    middles_s = 0.5 * (lidar.stamps_s[_SPAN:] + lidar.stamps_s[:-_SPAN])
    return _on_grid(middles_s, speeds, lidar.stamps_s[-1])


def _unit_speeds(unit: InertialDrive) -> Array:
    """(n,) rad/s on the grid from the first sample, over as long as the lidar's."""
    rates = unit.rates_radps - np.median(unit.rates_radps, axis=0) * _is_bias(unit.rates_radps)
    span_s = 0.1 * _SPAN
    width = max(1, round(span_s / float(np.median(np.diff(unit.stamps_s)))))
    kernel = np.ones(width) / width
    smooth = np.column_stack([np.convolve(column, kernel, mode="same") for column in rates.T])
    return _on_grid(unit.stamps_s, np.linalg.norm(smooth, axis=1), unit.stamps_s[-1])


def _is_bias(rates: Array) -> bool:
    """Whether the median of the rates is small enough for a bias: a drive in circles has another."""
    return bool(np.linalg.norm(np.median(rates, axis=0)) < 0.05)


def _on_grid(times_s: Array, values: Array, end_s: float) -> Array:
    gridded: Array = np.interp(np.arange(0.0, end_s, _GRID_S), times_s, values, left=np.nan, right=np.nan)
    return gridded


def _correlations(seen: Array, felt: Array) -> tuple[np.ndarray, Array]:
    """(shifts (s,), Pearson's correlations (s,)) for every shift of `felt` along `seen` on the grid.

    NaN where they have too little in common. Sums over what both have, by FFT.
    """
    size = 1 << (len(seen) + len(felt)).bit_length()
    a, b = np.nan_to_num(seen), np.nan_to_num(felt)
    in_a, in_b = np.isfinite(seen).astype(float), np.isfinite(felt).astype(float)

    def sums(one: Array, other: Array) -> Array:
        product = np.fft.irfft(np.fft.rfft(one, size) * np.conj(np.fft.rfft(other, size)), size)
        both: Array = np.concatenate((product[-(len(felt) - 1) :], product[: len(seen)]))
        return both

    count = sums(in_a, in_b)
    enough = count >= _OVERLAP_MIN * min(in_a.sum(), in_b.sum())
    n = np.where(enough, np.maximum(count, 1.0), 1.0)
    mean_a, mean_b = sums(a, in_b) / n, sums(in_a, b) / n
    variance_a = sums(a * a, in_b) / n - mean_a**2
    variance_b = sums(in_a, b * b) / n - mean_b**2
    covariance = sums(a, b) / n - mean_a * mean_b
    floor = 1e-8
    enough &= (variance_a > floor) & (variance_b > floor)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = np.where(enough, covariance / np.sqrt(variance_a * variance_b), np.nan)
    return np.arange(-(len(felt) - 1), len(seen)), ratios
