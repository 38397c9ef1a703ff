"""The trials of `benchmarks.signs`: counts, approaches, and ways without stop signs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.reporting.report import Row
from benchmarks.signs.road import Board, Scan, SignRoad, beside
from contract.geometry import Array, Pose2
from simulator.sensors.scene import sign_boards as shapes
from vehicle_agent.config import Profile
from vehicle_agent.perception.signs.tracks import SignsState, SignTrack, SignTracker
from vehicle_agent.signals import SignPercept
from vehicle_agent.stacks.rooms import sign_finder

RANGES_M = (6.9, 9.2, 10.0, 12.0, 15.0, 20.0, 25.0)
_SIGN_AT_M = 60.0
_BIN_M = 0.75
_VISIBLE_MIN = 0.95
# In free view so far before, too: what a tree has hidden until now is not known yet.
_FREE_M = 3.0
_NEAR_M = 1.0
PAPER_COUNTS = {9.2: 44, 6.9: 83}
SPEED_MPS = 3.0
_DIAMOND = shapes.rectangle(0.75, 0.75) @ np.array([[1.0, 1.0], [-1.0, 1.0]]) / np.sqrt(2.0)


def counted(profile: Profile, seed: int) -> dict[float, float]:
    """Points that the five stages keep of a stop sign square to a VLP-16, by range (GEM, section VI)."""
    rng = np.random.default_rng([seed, *b"counts"])
    board = Board("stop", shapes.octagon(), _SIGN_AT_M, 0.0, float(rng.uniform(1.5, 2.4)))
    rig = SignRoad(profile, [board], seed, width_m=6.0, trees=False).rig(four=False)
    finder, counts = sign_finder(profile), dict[float, float]()
    for range_m in PAPER_COUNTS:
        scan = rig.stand(_SIGN_AT_M - range_m - rig.x_m)
        found = _at(finder.percept(scan.points_base, scan.intensities, 1), scan, board)
        counts[range_m] = 0.0 if found is None else float(found[5])
    return counts


def count_rows(counts: Sequence[Mapping[float, float]]) -> list[Row]:
    """The means beside the paper's figures."""
    means = {at: float(np.mean([one[at] for one in counts])) for at in PAPER_COUNTS}
    return [
        {
            "trial": f"points at {at} m", "paper": paper, "mean": means[at],
            "difference_pct": 100.0 * (means[at] / paper - 1.0), "seeds": len(counts),
        }
        for at, paper in PAPER_COUNTS.items()
    ]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Passage:
    """What was known of a board at each of RANGES_M from which it was in free view.

    one_scan  a single scan showed it; names: the tracker's, "" without a track; hidden: ranges without view
    """

    one_scan: dict[float, bool]
    names: dict[float, str]
    hidden: int


def approach(profile: Profile, name: str, outline: Array, seed: int, *, four: bool) -> Passage:
    """One seed's drive past a board."""
    rng = np.random.default_rng([seed, *name.encode()])
    width_m = float(rng.uniform(3.5, 6.0))
    board = beside(name, outline, _SIGN_AT_M, width_m, rng)
    rig = SignRoad(profile, [board], seed, width_m=width_m).rig(four=four)
    finder, tracker, state = sign_finder(profile), SignTracker(), SignsState()
    passage, hidden = Passage({}, {}, 0), set[float]()
    free_since_m = math.inf
    for scan in rig.drive(SPEED_MPS, 26.0, 55.0, float(rng.uniform(-0.3, 0.3))):
        percept = finder.percept(scan.points_base, scan.intensities, scan.stamp_ns)
        state = tracker.step(state, percept, scan.pose_map)
        range_m = float(np.hypot(*(board.middle - [scan.pose_map.x_m + rig.x_m, scan.pose_map.y_m])))
        is_free = rig.visible_ratio(board, scan.pose_map) >= _VISIBLE_MIN
        free_since_m = (
            max(free_since_m, range_m)
            if is_free and free_since_m < math.inf
            else (range_m if is_free else math.inf)
        )
        at = next((at for at in RANGES_M if at <= range_m < at + _BIN_M), None)
        if at is None or at in passage.names:
            continue
        if not is_free or free_since_m < min(range_m + _FREE_M, 29.0):
            hidden.add(at)
            continue
        track = min(state.tracks, key=lambda track: _apart_m(track, board), default=None)
        is_there = track is not None and _apart_m(track, board) < _NEAR_M
        passage.one_scan[at] = _at(percept, scan, board) is not None
        passage.names[at] = track.name if track is not None and is_there else ""
    return Passage(passage.one_scan, passage.names, len(hidden - passage.names.keys()))


def approach_rows(name: str, lidars: str, passages: Sequence[Passage]) -> list[Row]:
    """Shares by range."""
    return [
        {
            "trial": f"{name} at {at} m, {lidars}",
            "seeds": sum(at in one.names for one in passages),
            "one_scan_pct": percent([one.one_scan[at] for one in passages if at in one.names]),
            "accumulated_pct": percent(known(passages, at)),
            "named_pct": percent(named(passages, at, name)),
            "misnamed_pct": percent(
                [one.names[at] in {"stop", "yield"} - {name} for one in passages if at in one.names]
            ),
        }
        for at in RANGES_M
    ]  # fmt: skip


def known(passages: Sequence[Passage], at: float) -> list[bool]:
    """Whether the tracker had the board there, of all passages with a free view."""
    return [one.names[at] != "" for one in passages if at in one.names]


def named(passages: Sequence[Passage], at: float, name: str) -> list[bool]:
    """Whether it had its right name there."""
    return [one.names[at] == name for one in passages if at in one.names]


# Boards that are no stop signs.
OTHERS: dict[str, Array] = {
    "yield": shapes.triangle(), "plate": shapes.rectangle(0.6, 0.6), "high plate": shapes.rectangle(0.6, 0.9),
    "large plate": shapes.rectangle(0.75, 0.75), "wide plate": shapes.rectangle(0.9, 0.45),
    "disc": shapes.disc(0.6), "warning": shapes.triangle(0.9, upright=True), "diamond": _DIAMOND,
    "small disc": shapes.disc(0.45),
}  # fmt: skip


def false_stops(profile: Profile, seed: int, length_m: float, *, four: bool) -> tuple[float, list[str]]:
    """(metres driven, names of the boards taken for stop signs) on a way with other reflecting things.

    One board of `OTHERS` every 40 m, on either side, at 0.8 m to 2.4 m above the ground.
    """
    rng = np.random.default_rng([seed, *b"no stops"])
    width_m = float(rng.uniform(3.5, 6.0))
    boards = []
    for x_m in np.arange(40.0, length_m - 10.0, 40.0):
        name = str(rng.choice(list(OTHERS)))
        board = beside(name, OTHERS[name], float(x_m + rng.uniform(-10.0, 10.0)), width_m, rng)
        side = 1.0 if rng.random() < 0.3 else -1.0
        bottom_m = float(rng.uniform(0.8, 2.4))
        boards.append(
            Board(name, board.outline, board.x_m, side * abs(board.y_m), bottom_m, board.turned_rad)
        )
    rig = SignRoad(profile, boards, seed, width_m=width_m, length_m=length_m).rig(four=four)
    finder, tracker, state = sign_finder(profile), SignTracker(), SignsState()
    taken: dict[int, str] = {}
    y_m = float(rng.uniform(-0.3, 0.3))
    for scan in rig.drive(SPEED_MPS, 5.0, length_m - 5.0, y_m):
        percept = finder.percept(scan.points_base, scan.intensities, scan.stamp_ns)
        state = tracker.step(state, percept, scan.pose_map)
        for track in state.tracks:
            if track.name == "stop":
                nearest = min(boards, key=lambda board: _apart_m(track, board))
                taken[track.sign_id] = nearest.name if _apart_m(track, nearest) < _NEAR_M else "no board"
    return length_m - 10.0, list(taken.values())


def _at(percept: SignPercept, scan: Scan, board: Board) -> Array | None:
    """The percept's row of a board."""
    pose: Pose2 = scan.pose_map
    for row in percept.boards_base:
        if np.hypot(row[0] + pose.x_m - board.x_m, row[1] + pose.y_m - board.y_m) < _NEAR_M:
            found: Array = row
            return found
    return None


def _apart_m(track: SignTrack, board: Board) -> float:
    return float(np.hypot(track.x_m - board.x_m, track.y_m - board.y_m))


def percent(outcomes: list[bool]) -> float:
    return 100.0 * float(np.mean(outcomes)) if outcomes else 0.0
