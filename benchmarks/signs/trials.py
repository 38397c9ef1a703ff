"""The trials of `benchmarks.signs`: counts, approaches, and ways without stop signs."""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from benchmarks.reporting.report import Row
from benchmarks.signs.road import Board, Rig, Scan, SignRoad, beside
from contract.geometry import Array, Pose2
from simulator.sensors.scene import sign_boards as shapes
from vehicle_agent.config import Profile
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.signs.tracks import SignsState, SignTrack, SignTracker
from vehicle_agent.signals import SignPercept
from vehicle_agent.stacks.rooms import sign_finder

RANGES_M = (6.9, 9.2, 10.0, 12.0, 15.0, 20.0, 25.0)
_SIGN_AT_M = 60.0
_BIN_M = 0.75
_VISIBLE_MIN = 0.8
_NEAR_M = 1.0
_PAPER_COUNTS = {9.2: 44, 6.9: 83}
_DIAMOND = shapes.rectangle(0.75, 0.75) @ np.array([[1.0, 1.0], [-1.0, 1.0]]) / np.sqrt(2.0)


def count_rows(profile: Profile, seeds: Iterable[int]) -> list[Row]:
    """Points that the five stages keep of a stop sign square to a VLP-16, as in GEM, section VI."""
    finder, counts = sign_finder(profile), defaultdict(list)
    for seed in seeds:
        rng = np.random.default_rng([seed, *b"counts"])
        board = Board("stop", shapes.octagon(), _SIGN_AT_M, 0.0, float(rng.uniform(1.5, 2.4)))
        rig = SignRoad(profile, [board], seed, width_m=6.0, trees=False).rig(four=False)
        for range_m in _PAPER_COUNTS:
            scan = rig.stand(_SIGN_AT_M - range_m - rig.x_m)
            found = _at(finder.percept(scan.points_base, scan.intensities, 1), scan, board)
            counts[range_m].append(0.0 if found is None else found[5])
    return [
        {
            "trial": f"points at {range_m} m", "paper": paper, "mean": float(np.mean(counts[range_m])),
            "difference_pct": 100.0 * (float(np.mean(counts[range_m])) / paper - 1.0),
            "seeds": len(counts[range_m]),
        }
        for range_m, paper in _PAPER_COUNTS.items()
    ]  # fmt: skip


class Approach:
    """What was found of one sign by range, over many seeds."""

    def __init__(self, name: str, outline: Array, *, four: bool) -> None:
        self.name, self.outline, self.four = name, outline, four
        self.found: dict[float, list[bool]] = {at: [] for at in RANGES_M}
        self.known: dict[float, list[bool]] = {at: [] for at in RANGES_M}
        self.named: dict[float, list[bool]] = {at: [] for at in RANGES_M}
        self.wrong: dict[float, list[bool]] = {at: [] for at in RANGES_M}
        self.hidden = 0

    def drive(self, profile: Profile, seed: int, speed_mps: float) -> None:
        rng = np.random.default_rng([seed, *self.name.encode()])
        width_m = float(rng.uniform(3.5, 6.0))
        board = beside(self.name, self.outline, _SIGN_AT_M, width_m, rng)
        road = SignRoad(profile, [board], seed, width_m=width_m)
        rig, finder, tracker = road.rig(four=self.four), sign_finder(profile), SignTracker()
        state = SignsState()
        hidden: set[float] = set()
        seen: dict[float, tuple[bool, SignTrack | None]] = {}
        for scan in rig.drive(speed_mps, 26.0, 55.0, float(rng.uniform(-0.3, 0.3))):
            percept = finder.percept(scan.points_base, scan.intensities, scan.stamp_ns)
            state = tracker.step(state, percept, scan.pose_map)
            range_m = float(np.hypot(*(board.middle - [scan.pose_map.x_m + rig.x_m, scan.pose_map.y_m])))
            at = next((at for at in RANGES_M if at <= range_m < at + _BIN_M and at not in seen), None)
            if at is None:
                continue
            if rig.visible_ratio(board, scan.pose_map) < _VISIBLE_MIN:
                hidden.add(at)
                continue
            track = min(state.tracks, key=lambda track: _apart_m(track, board), default=None)
            is_there = track is not None and _apart_m(track, board) < _NEAR_M
            seen[at] = (_at(percept, scan, board) is not None, track if is_there else None)
        self._count(seen, hidden)

    def _count(self, seen: dict[float, tuple[bool, SignTrack | None]], hidden: set[float]) -> None:
        self.hidden += len(hidden - seen.keys())
        for at, (found, track) in seen.items():
            name = "" if track is None else track.name
            self.found[at].append(found)
            self.known[at].append(track is not None)
            self.named[at].append(name == self.name)
            self.wrong[at].append(name in ("stop", "yield") and name != self.name)

    def rows(self) -> list[Row]:
        lidars = "four XT16" if self.four else "VLP-16"
        return [
            {
                "trial": f"{self.name} at {at} m, {lidars}", "seeds": len(self.found[at]),
                "one_scan_pct": _percent(self.found[at]), "accumulated_pct": _percent(self.known[at]),
                "named_pct": _percent(self.named[at]), "misnamed_pct": _percent(self.wrong[at]),
            }
            for at in RANGES_M
        ]  # fmt: skip


# Boards that are no stop signs.
OTHERS: dict[str, Array] = {
    "yield": shapes.triangle(), "plate": shapes.rectangle(0.6, 0.6), "high plate": shapes.rectangle(0.6, 0.9),
    "large plate": shapes.rectangle(0.75, 0.75), "wide plate": shapes.rectangle(0.9, 0.45),
    "disc": shapes.disc(0.6), "warning": shapes.triangle(0.9, upright=True), "diamond": _DIAMOND,
    "small disc": shapes.disc(0.45),
}  # fmt: skip


def false_stops(
    profile: Profile, seed: int, length_m: float, speed_mps: float, *, four: bool
) -> tuple[float, list[str]]:
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
    for scan in rig.drive(speed_mps, 5.0, length_m - 5.0, y_m):
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


def _percent(outcomes: list[bool]) -> float:
    return 100.0 * float(np.mean(outcomes)) if outcomes else 0.0
