"""How well tracks keep identities: `python -m benchmarks.tracker [DIR] [--json F]`.

DIR has CSV files of boxes at 10 Hz (class, x, y, z, length, width, height, yaw, track). A file with a column
`frame` or `time` is a sequence; the other files of a folder are the frames of one sequence, by name. Boxes
are dropped, moved, added and given other kinds by a seed. Simulated crowds are treated alike. Each row is a
sequence:

hota, idf1         of the vehicle's tracker; nn_hota, nn_idf1: of a nearest-neighbour tracker
switches           how often a road user's track changed
speed_error_mps    median error of the velocities, of those whose true motion is known
cpu_ms             a frame of the tracker, mean
"""

import argparse
import math
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.tracker.metrics import FrameTracks, TrackScores, scores_of
from benchmarks.tracker.nearest_neighbour import NearestNeighbourTracker
from benchmarks.tracker.sequences import (
    Corruption,
    Sequence10Hz,
    TrueFrame,
    corrupted,
    crowd_sequence,
    read_sequences,
)
from contract.geometry import Array, IntArray, Pose2
from vehicle_agent.perception.tracking.tracker import ObjectTracker
from vehicle_agent.signals.objects import SeenObjects

_HERE = Pose2(0.0, 0.0, 0.0)
_NEAR_M = 0.5


def main() -> None:
    arguments = _arguments()
    report = RunReport()
    sequences: list[Sequence10Hz] = []
    messages: list[str] = []
    if arguments.folder is not None:
        sequences, messages = read_sequences(arguments.folder)
        for message in messages:
            print(f"left out: {message}", file=sys.stderr)
        if not sequences:
            sys.exit(f"{arguments.folder} has no sequence of boxes")
    crowds = [
        crowd_sequence(density, arguments.seconds, seed)
        for density in (2.0, 8.0)
        for seed in range(arguments.seed, arguments.seed + arguments.crowds)
    ]
    rows = [row_of(sequence, arguments.seed) for sequence in (*sequences, *crowds)]
    read, dense = rows[: len(sequences)], rows[len(sequences) + arguments.crowds :]
    judged = read or rows
    summary: Row = {
        "hota": _mean(judged, "hota"),
        "idf1": _mean(judged, "idf1"),
        "nearest_neighbour_hota": _mean(judged, "nn_hota"),
        "nearest_neighbour_idf1": _mean(judged, "nn_idf1"),
        "crowd_idf1": _mean(dense, "idf1"),
        "crowd_hota": _mean(dense, "hota"),
        "crowd_nearest_neighbour_hota": _mean(dense, "nn_hota"),
        "left_out": len(messages),
    }
    plain = {"folder": str(arguments.folder), "seed": arguments.seed, "seconds": arguments.seconds}
    report.write(arguments.json, "tracker", plain, rows, summary)


def row_of(sequence: Sequence10Hz, seed: int, corruption: Corruption | None = None) -> Row:
    """The scores of both trackers on the same corrupted boxes."""
    seen = corrupted(sequence, corruption or Corruption(), seed)
    ours, errors, cpu_ms = _tracked(sequence, seen)
    peer = NearestNeighbourTracker()
    last_s, theirs = seen[0][0], []
    for frame, (time_s, _, poses, _) in zip(sequence.frames, seen, strict=True):
        ids, places = peer.step(poses[:, :2].copy(), time_s - last_s)
        last_s = time_s
        theirs.append(_frame_tracks(frame, ids, places))
    mine, other = scores_of(ours), scores_of(theirs)
    return {
        "sequence": sequence.name,
        "frames": len(sequence.frames),
        "road_users": len({int(one) for frame in sequence.frames for one in frame.ids}),
        **_columns(mine, ""),
        **_columns(other, "nn_"),
        "switches": mine.switches,
        "nn_switches": other.switches,
        "speed_error_mps": float(np.median(errors)) if len(errors) else None,
        "cpu_ms": cpu_ms,
    }


def _tracked(
    sequence: Sequence10Hz, seen: list[tuple[float, IntArray, Array, Array]]
) -> tuple[list[FrameTracks], list[float], float]:
    """(frames, errors of velocities, mean processor time of a frame) of the vehicle's tracker."""
    tracker = ObjectTracker(viewpoint_x_m=0.0)
    state = tracker.initial()
    frames, errors, spent_s = [], [], 0.0
    begin_s = seen[0][0]
    for number, (time_s, kinds, poses, sizes) in enumerate(seen):
        stamp_ns = 1_000_000_000 + round((time_s - begin_s) * 1e9)
        objects = SeenObjects(
            stamp_ns, kinds, np.full(len(kinds), 0.7), poses, sizes, np.full((len(kinds), 2), math.nan)
        )
        begun_s = time.process_time()
        percept, state = tracker.step(state, objects, _HERE)
        spent_s += (time.process_time() - begun_s) * (number > 0)
        frame = sequence.frames[number]
        frames.append(_frame_tracks(frame, percept.ids, percept.poses_base[:, :2]))
        if number >= 10:
            errors += _velocity_errors(
                sequence.frames[number - 1], frame, percept.poses_base, percept.velocities_base_mps
            )
    return frames, errors, 1e3 * spent_s / max(len(seen) - 1, 1)


def _frame_tracks(frame: TrueFrame, ids: IntArray, places: Array) -> FrameTracks:
    return FrameTracks(frame.ids, frame.poses[:, :2], ids, places, frame.reach_m)


def _velocity_errors(before: TrueFrame, frame: TrueFrame, poses: Array, velocities: Array) -> list[float]:
    """Of each true road user with a track nearby; the truth is the way since the frame before."""
    known = {int(one): place for one, place in zip(before.ids, before.poses, strict=True)}
    errors: list[float] = []
    if not len(poses) or frame.time_s <= before.time_s:
        return errors
    for one, place in zip(frame.ids, frame.poses, strict=True):
        apart = np.hypot(poses[:, 0] - place[0], poses[:, 1] - place[1])
        nearest = int(np.argmin(apart))
        if int(one) in known and apart[nearest] < _NEAR_M:
            true = (place[:2] - known[int(one)][:2]) / (frame.time_s - before.time_s)
            errors.append(float(np.hypot(*(velocities[nearest] - true))))
    return errors


def _columns(scores: TrackScores, prefix: str) -> Row:
    return {f"{prefix}hota": scores.hota, f"{prefix}idf1": scores.idf1}


def _mean(rows: list[Row], name: str) -> float:
    return float(np.mean([float(row[name] or 0.0) for row in rows]))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="benchmarks.tracker", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?", help="sequences; without it crowds alone")
    parser.add_argument("--seconds", type=float, default=30.0, help="of each crowd")
    parser.add_argument("--crowds", type=int, default=3, help="of each density")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
