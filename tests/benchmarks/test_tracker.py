"""Scores of tracks: known small cases, and sequences of files."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.tracker.__main__ import row_of
from benchmarks.tracker.metrics import ALPHAS, FrameTracks, scores_of
from benchmarks.tracker.sequences import Corruption, crowd_sequence, read_sequences


def frames(ids: list[list[int]], off_m: float = 0.0) -> list[FrameTracks]:
    """Two true road users 10 m apart, and tracks with these ids in each frame: the first on the first one."""
    truth = np.array([[0.0, 0.0], [10.0, 0.0]])
    return [
        FrameTracks(
            np.array([1, 2]),
            truth,
            np.array(row, np.int64),
            truth[: len(row)] + np.array([off_m, 0.0]),
            np.ones(2),
        )
        for row in ids
    ]


def test_perfect_tracks_score_one() -> None:
    scores = scores_of(frames([[7, 8]] * 4))
    assert (scores.hota, scores.idf1, scores.switches) == (pytest.approx(1.0), 1.0, 0)


def test_an_identity_that_changes_half_way_halves_the_association() -> None:
    scores = scores_of(frames([[7], [7], [9], [9]])[:4])
    # Of 8 true places 4 are tracked. Each track has 2 of its true user's 4 places.
    assert scores.detection == pytest.approx(0.5)
    assert scores.association == pytest.approx(0.5)
    assert scores.hota == pytest.approx(0.5)
    assert scores.idf1 == pytest.approx(2 * 2 / (8 + 4))
    assert scores.switches == 1


def test_tracks_beside_their_place_count_for_the_wider_thresholds_alone() -> None:
    scores = scores_of(frames([[7, 8]] * 3, off_m=0.42))
    assert scores.hota == pytest.approx(sum(alpha <= 0.58 for alpha in ALPHAS) / len(ALPHAS))
    assert scores.idf1 == 1.0
    assert scores_of(frames([[7, 8]] * 3, off_m=0.62)).idf1 == 0.0


def test_nothing_tracked_scores_nothing_and_nothing_there_one() -> None:
    assert scores_of(frames([[], []])).hota == 0.0
    none = FrameTracks(
        np.empty(0, np.int64), np.empty((0, 2)), np.empty(0, np.int64), np.empty((0, 2)), np.empty(0)
    )
    assert scores_of([none]).hota == 1.0


def test_the_tracker_beats_nearest_neighbours_in_a_crowd() -> None:
    row = row_of(crowd_sequence(8.0, 6.0, seed=4), seed=4)
    assert float(row["hota"] or 0.0) > float(row["nn_hota"] or 1.0)
    assert float(row["idf1"] or 0.0) > 0.8
    clean = row_of(crowd_sequence(8.0, 6.0, seed=4), 4, Corruption(0.0, 1, 0.0, 0.0, 0.0))
    assert float(clean["idf1"] or 0.0) > float(row["idf1"] or 1.0)


def test_files_become_sequences_by_column_or_by_name(tmp_path: Path) -> None:
    header = "class,x,y,z,length,width,height,yaw,track"
    one = "\n".join([f"frame,{header}", *(f"{k},Pedestrian,{k / 10},0,0,0.5,0.5,1.7,0,a" for k in range(12))])
    (tmp_path / "one.csv").write_text(one)
    many = tmp_path / "many"
    many.mkdir()
    for k in range(12):
        (many / f"{k:03d}.csv").write_text(f"{header}\ncar,{k / 2},3,0,4.4,1.8,1.5,0,b\n")
    (tmp_path / "bad.csv").write_text("nothing\n")
    sequences, messages = read_sequences(tmp_path)
    assert sorted(sequence.name for sequence in sequences) == ["many", "one"]
    assert [len(sequence.frames) for sequence in sequences] == [12, 12]
    assert any("bad.csv" in message for message in messages)
    assert sequences[0].frames[3].time_s == pytest.approx(0.3)
