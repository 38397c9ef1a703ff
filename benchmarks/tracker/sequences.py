"""Sequences of true boxes: from files of annotations, and from simulated crowds."""

import itertools
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.pointclouds.annotations import AnnotationError, Annotations, read_annotations
from contract.geometry import Array, IntArray
from simulator.traffic.social_crowd import CrowdParams, SocialCrowd
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN

PERIOD_S = 0.1
_STEP_S = 0.02
# Files whose tracks hardly come again in the next one are no frames of one sequence.
_SHARED_MIN = 0.3
# A person and a cyclist are found within a metre of their place or not at all.
_REACH_M = {PEDESTRIAN: 1.0, CYCLIST: 1.0}
_REACH_OTHERS_M = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class TrueFrame:
    """time_s; ids (n,), kinds (n,), poses (n, 3) x, y, yaw, sizes_m (n, 3), reach_m (n,)."""

    time_s: float
    ids: IntArray
    kinds: IntArray
    poses: Array
    sizes_m: Array
    reach_m: Array


@dataclass(frozen=True, slots=True, eq=False)
class Sequence10Hz:
    name: str
    frames: tuple[TrueFrame, ...]


def read_sequences(folder: Path) -> tuple[list[Sequence10Hz], list[str]]:
    """(sequences, messages about what was left out) of all CSV files below a folder.

    A file with a column `frame` or `time` is a sequence of its own. The others of one folder are the frames
    of one sequence, in the order of their names.
    """
    sequences, messages = [], []
    single: dict[Path, list[tuple[Path, Annotations]]] = defaultdict(list)
    for path in sorted(folder.rglob("*.csv")):
        try:
            boxes = read_annotations(path)
        except AnnotationError as error:
            messages.append(str(error))
            continue
        if len(boxes) and not any(boxes.tracks):
            messages.append(f"{path.name}: no column track, or no names in it")
        elif len(boxes) and boxes.frames.max() > 0:
            frames = [
                _frame(boxes, boxes.frames == number, number) for number in range(boxes.frames.max() + 1)
            ]
            sequences.append(Sequence10Hz(path.stem, _with_numbers(frames)))
        else:
            single[path.parent].append((path, boxes))
    for parent, files in single.items():
        frames = [
            _frame(boxes, np.ones(len(boxes), np.bool_), number) for number, (_, boxes) in enumerate(files)
        ]
        if len(files) < 2 or _shared(frames) < _SHARED_MIN:
            messages.append(f"{parent.name}: {len(files)} files without frames or times are no sequence")
            continue
        sequences.append(Sequence10Hz(parent.name, _with_numbers(frames)))
    return sequences, messages


def _frame(boxes: Annotations, chosen: np.ndarray, number: int) -> tuple[float, list[str], TrueFrame]:
    """(time, names of the tracks, frame without numbers for them)."""
    rows = np.flatnonzero(chosen)
    rows = np.array([k for k in rows if boxes.tracks[k] and boxes.kinds[k] != OTHER], dtype=np.int64)
    times = boxes.times_s[rows]
    time_s = float(times[0]) if len(times) and times[0] >= 0.0 else number * PERIOD_S
    kinds = boxes.kinds[rows]
    frame = TrueFrame(
        time_s,
        np.zeros(len(rows), np.int64),
        kinds,
        np.column_stack((boxes.centres[rows, :2], boxes.yaws[rows])).reshape(-1, 3),
        boxes.sizes_m[rows],
        np.array([_REACH_M.get(int(kind), _REACH_OTHERS_M) for kind in kinds]),
    )
    return time_s, [boxes.tracks[k] for k in rows], frame


def _shared(frames: Sequence[tuple[float, list[str], TrueFrame]]) -> float:
    """Mean share of a frame's tracks that the next one has, too."""
    shares = [
        len(set(before) & set(after)) / len(before)
        for (_, before, _), (_, after, _) in itertools.pairwise(frames)
        if before
    ]
    return float(np.mean(shares)) if shares else 0.0


def _with_numbers(frames: Sequence[tuple[float, list[str], TrueFrame]]) -> tuple[TrueFrame, ...]:
    numbers: dict[str, int] = {}
    for _, names, frame in frames:
        for row, name in enumerate(names):
            frame.ids[row] = numbers.setdefault(name, len(numbers))
    return tuple(frame for _, _, frame in frames)


def crowd_sequence(people_per_100m2: float, seconds: float, seed: int) -> Sequence10Hz:
    """People who cross, walk along and stand, on 30 m of a way; their boxes at 10 Hz."""
    way = np.column_stack((np.linspace(0.0, 30.0, 31), np.zeros(31)))
    crowd = SocialCrowd(CrowdParams(people_per_100m2, reach_m=8.0), way, seed)
    no_vehicles, no_ahead = np.zeros((0, 7)), np.zeros((0, 1, 2))
    frames = []
    for step in range(round(seconds / _STEP_S)):
        crowd.step(no_vehicles, np.zeros(0), no_ahead, _STEP_S)
        if step % round(PERIOD_S / _STEP_S) == 0:
            bodies = crowd.bodies()
            n = len(bodies.numbers)
            frames.append(
                TrueFrame(
                    step * _STEP_S,
                    bodies.numbers.copy(),
                    bodies.kinds.copy(),
                    bodies.poses_map.copy(),
                    np.tile([0.5, 0.5, 1.7], (n, 1)),
                    np.full(n, _REACH_M[PEDESTRIAN]),
                )
            )
    return Sequence10Hz(f"crowd {people_per_100m2:g}/100 m2, seed {seed}", tuple(frames))


@dataclass(frozen=True, slots=True)
class Corruption:
    """What a finder does to true boxes.

    dropped, false  shares of boxes that are missing, and that are added within the boxes' extent
    gap_frames      a dropped box stays away for 1 to so many frames
    moved_m         standard deviation of a middle
    confused        share of boxes with another kind
    """

    dropped: float = 0.1
    gap_frames: int = 3
    false: float = 0.05
    moved_m: float = 0.1
    confused: float = 0.05


def half_extent(values: Array) -> tuple[float, float]:
    """(least, greatest) of values; a metre around 0 for none."""
    return (float(values.min()), float(values.max())) if len(values) else (-1.0, 1.0)


def corrupted(
    sequence: Sequence10Hz, corruption: Corruption, seed: int
) -> list[tuple[float, IntArray, Array, Array]]:
    """(time, kinds (k,), poses (k, 3), sizes (k, 3)) of each frame as a finder might give it."""
    rng = np.random.default_rng([seed, *b"boxes"])
    away: dict[int, int] = {}
    seen = []
    for frame in sequence.frames:
        kept = np.ones(len(frame.ids), np.bool_)
        for row, one in enumerate(frame.ids.tolist()):
            left = away.get(one, 0)
            # So many begin to be away that the wanted share is.
            if left == 0 and rng.random() < 2.0 * corruption.dropped / (1.0 + corruption.gap_frames):
                left = int(rng.integers(1, corruption.gap_frames + 1))
            kept[row] = left == 0
            away[one] = max(0, left - 1)
        poses = frame.poses[kept] + rng.normal(0.0, 1.0, (int(kept.sum()), 3)) * [
            corruption.moved_m, corruption.moved_m, 0.05,
        ]  # fmt: skip
        kinds, sizes = frame.kinds[kept].copy(), frame.sizes_m[kept].copy()
        mixed = rng.random(len(kinds)) < corruption.confused
        kinds[mixed] = rng.integers(0, 4, int(mixed.sum()))
        false = int(rng.poisson(corruption.false * len(frame.ids)))
        x, y = half_extent(frame.poses[:, 0]), half_extent(frame.poses[:, 1])
        added = np.column_stack(
            (rng.uniform(*x, false), rng.uniform(*y, false), rng.uniform(-math.pi, math.pi, false))
        )
        seen.append(
            (
                frame.time_s,
                np.concatenate((kinds, rng.integers(0, 4, false))),
                np.vstack((poses, added)),
                np.vstack((sizes, np.tile([0.5, 0.5, 1.7], (false, 1)))),
            )
        )
    return seen
