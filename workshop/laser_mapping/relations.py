"""Relations: what is known of the relative poses of a log's scans, and how far a trajectory is from them.

The format and the measure are those of the published SLAM benchmark (Kuemmerle et al. 2009). A line has two
stamps and the second pose as the first one sees it: `t1 t2 dx dy dz droll dpitch dyaw`.
"""

from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.laser.pose_arrays import between
from workshop.carmen.log_files import LogFileError, read_log_text

_FIELDS = 8
# Stamps are written with microseconds; a relation belongs to one scan and not to the time between two.
_SAME_STAMP_S = 0.01


class Relations(msgspec.Struct, frozen=True):
    """stamps_s (n, 2) of the two scans; poses (n, 3) of the second in the frame of the first."""

    stamps_s: Array
    poses: Array


class RelationErrors(msgspec.Struct, frozen=True):
    """translations_m, rotations_rad (k,) where both scans are in the log; missing: other relations."""

    translations_m: Array
    rotations_rad: Array
    missing: int


def read_relations(path: Path) -> Relations:
    """The relations of this file, plain or compressed. Raises LogFileError where it is none."""
    text, _ = read_log_text(path)
    rows = []
    for line in text.splitlines():
        fields = line.split()
        if not fields or fields[0].startswith("#"):
            continue
        try:
            row = [float(field) for field in fields]
        except ValueError:
            row = []
        if len(row) != _FIELDS or not np.isfinite(row).all():
            raise LogFileError(f"{path} is no relations file: {line[:60]!r} is not 8 numbers.")
        rows.append(row)
    if not rows:
        raise LogFileError(f"{path} is no relations file: it has no line of 8 numbers.")
    values = np.array(rows)
    return Relations(values[:, :2], values[:, [2, 3, 7]])


def relation_errors(relations: Relations, stamps_s: Array, poses: Array) -> RelationErrors:
    """How far the poses (n, 3) at these stamps (n,) deviate from each relation."""
    order = np.argsort(stamps_s, kind="stable")
    after = np.searchsorted(stamps_s[order], relations.stamps_s)
    before = np.clip(after - 1, 0, len(order) - 1)
    after = np.clip(after, 0, len(order) - 1)
    is_before = np.abs(stamps_s[order[before]] - relations.stamps_s) <= np.abs(
        stamps_s[order[after]] - relations.stamps_s
    )
    scans = order[np.where(is_before, before, after)]
    found = (np.abs(stamps_s[scans] - relations.stamps_s) <= _SAME_STAMP_S).all(axis=1)
    estimated = between(poses[scans[found, 0]], poses[scans[found, 1]])
    errors = between(relations.poses[found], estimated)
    return RelationErrors(np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2]), int((~found).sum()))
