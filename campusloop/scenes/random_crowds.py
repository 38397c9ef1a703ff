"""Random scenes among people; each is drawn completely from its seed."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from campusloop.scenes.drive import PausableActors, Scene
from campusloop.scenes.path_map import path_map
from contract.geometry import Array, arc_lengths, pose_at, resample
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from simulator.sensors.tracker import TrackerNoise
from simulator.traffic.recordings import Clip, RecordedTrack, RecordingError, drone_clips, pavement_clip
from simulator.traffic.replayed import ReplayedTraffic
from simulator.traffic.social_crowd import CrowdParams, SocialCrowd
from simulator.world import WorldOptions
from vehicle_agent.config import Profile
from vehicle_agent.signals import PEDESTRIAN

SPARSE_PER_100M2 = 1.0
# From here on a crowd is dense.
DENSE_PER_100M2 = 5.0
_LENGTH_M = (50.0, 85.0)
_LANE_M_MIN = 45.0
_PER_100M2 = (0.3, 8.0)
_REACH_M = 12.0
_AFTER_M = 12.0
_SPEED_LIMIT_MPS = 4.2
_PEOPLE_MIN = 4
_EDGE_S = 6.0
# A recorded person who would appear nearer to the shuttle is left out: no vehicle could react in time.
_APPEAR_M = 15.0
# Around the path's first point; the rear axle starts 5 to 10 m along the path.
_CLEAR_M = 18.0
# A start with speed is on a way that bends less, over so much before and behind it.
_START_BEND_1PM, _BEND_M = 0.07, 1.5


@dataclass(frozen=True, slots=True)
class SceneSources:
    """The lanes and recordings that scenes are drawn from. lanes: (name, points (n, 2), width_m)."""

    lanes: tuple[tuple[str, Array, float], ...]
    clips: tuple[Clip, ...]


@dataclass(frozen=True, slots=True)
class RandomScene:
    """A scene with its parameters.

    people_per_100m2  as drawn, or the recording's average
    removed_at_start  recorded people who were left out, since they would appear beside the shuttle
    """

    scene: Scene
    path: str
    crowd: str
    people_per_100m2: float
    removed_at_start: int = 0

    @property
    def is_sparse(self) -> bool:
        return self.people_per_100m2 <= SPARSE_PER_100M2

    @property
    def is_dense(self) -> bool:
        return self.people_per_100m2 >= DENSE_PER_100M2

    @property
    def removed(self) -> int:
        """Recorded people who were taken out of the scene so far, at the start and by `appear_m`."""
        actors = self.scene.actors
        appeared = len(actors.removed) if isinstance(actors, ReplayedTraffic) else 0
        return self.removed_at_start + appeared

    def without_people(self) -> Scene:
        return replace(self.scene, actors=None)


def scene_sources(maps: tuple[Path, ...], recordings: Path | None) -> SceneSources:
    """The maps' lanes that are long enough, and all recordings below the folder. Raises RecordingError."""
    lanes = []
    for path in maps:
        network = RoadNetwork(load_map(path))
        for lane_id, line in network.lines.items():
            if line.length_m >= _LANE_M_MIN:
                lane = network.lanes[lane_id]
                lanes.append((f"{path.parent.name} {lane_id}", line.points, lane.width_m))
    return SceneSources(tuple(lanes), _clips(recordings) if recordings is not None else ())


def _clips(folder: Path) -> tuple[Clip, ...]:
    clips = [pavement_clip(path) for path in sorted(folder.rglob("obsmat.txt"))]
    if not clips or any(folder.rglob("*_ped_filtered.csv")):
        clips += drone_clips(folder)
    peopled = [clip for clip in clips if sum(t.kind == PEDESTRIAN for t in clip.tracks) >= _PEOPLE_MIN]
    if not peopled:
        raise RecordingError(f"{folder}: no recording there has {_PEOPLE_MIN} people")
    return tuple(peopled)


def draw_scene(found: SceneSources, profile: Profile, seed: int) -> RandomScene:
    """Draw a scene. It depends on the sources and the seed, not on the profile's limits."""
    rng = np.random.default_rng([seed, *b"monte carlo"])
    path_name, points, width_m = _path(found, rng)
    length_m = float(arc_lengths(points)[-1])
    start_s_m = float(rng.uniform(5.0, 10.0))
    start_mps = float(rng.choice((0.0, rng.uniform(0.5, 2.5))))
    if _bend_1pm(points, start_s_m) > _START_BEND_1PM:
        # A vehicle that drives in a bend has its wheels turned, and a scene begins with straight ones.
        start_mps = 0.0
    noise = random_tracker_noise(rng)
    crowd_name, density, removed, actors = _crowd(found, points, seed, rng)
    name = f"run-{seed:06d}"
    scene = Scene(
        name=name,
        road_map=path_map(name, points, width_m=width_m, speed_limit_mps=_SPEED_LIMIT_MPS),
        profile=profile,
        start_s_m=start_s_m,
        start_mps=min(start_mps, profile.limits.speed_mps_max),
        goal_s_m=length_m - _AFTER_M,
        limit_s=30.0 + 3.0 * length_m,
        seed=seed,
        actors=actors(),
        options=WorldOptions(traffic=None, tracker=noise),
    )
    return RandomScene(scene, path_name, crowd_name, density, removed)


def random_tracker_noise(rng: np.random.Generator) -> TrackerNoise:
    """Of a better or worse tracker than the usual one."""
    return TrackerNoise(
        position_std_m=float(rng.uniform(0.03, 0.12)),
        velocity_std_mps=float(rng.uniform(0.05, 0.2)),
        dropout_ratio=float(rng.uniform(0.0, 0.1)),
        latency_ns=round(float(rng.uniform(0.06, 0.14)) * 1e9),
    )


def _bend_1pm(points: Array, s_m: float) -> float:
    """Of the way about s_m, over some metres: lanes are polylines."""
    s = arc_lengths(points)
    before, after = (pose_at(points, s, s_m + side_m)[2] for side_m in (-_BEND_M, _BEND_M))
    return abs(math.remainder(after - before, 2.0 * math.pi)) / (2.0 * _BEND_M)


def _path(found: SceneSources, rng: np.random.Generator) -> tuple[str, Array, float]:
    """(description, points (n, 2), width_m): a lane of the maps or a random curve, with equal probability."""
    length_m = float(rng.uniform(*_LENGTH_M))
    if found.lanes and rng.random() < 0.5:
        name, points, width_m = found.lanes[int(rng.integers(len(found.lanes)))]
        points = resample(np.ascontiguousarray(points), 0.5)
        s = arc_lengths(points)
        begin_m = float(rng.uniform(0.0, max(0.0, s[-1] - length_m)))
        return name, points[(s >= begin_m) & (s <= begin_m + length_m)], max(width_m, 3.0)
    return "curve", random_curve(length_m, rng), float(rng.uniform(3.5, 8.0))


def random_curve(length_m: float, rng: np.random.Generator, radius_m_min: float = 9.0) -> Array:
    """(n, 2) a point every half metre; the curvature is linear between random values."""
    knots = max(3, round(length_m / 15.0) + 1)
    bends = rng.uniform(-1.0, 1.0, knots) / radius_m_min * (rng.random(knots) < 0.6)
    s = np.arange(0.0, length_m, 0.5)
    curvature = np.interp(s, np.linspace(0.0, length_m, knots), bends)
    # The total turn stays below a half circle, so that the path does not cross itself.
    turn = np.cumsum(curvature) * 0.5
    widest = float(np.ptp(turn))
    turn *= min(1.0, 0.9 * math.pi / max(widest, 1e-9))
    steps = 0.5 * np.column_stack((np.cos(turn), np.sin(turn)))
    points: Array = np.vstack((np.zeros((1, 2)), np.cumsum(steps, axis=0)))
    return points


def _crowd(
    found: SceneSources, points: Array, seed: int, rng: np.random.Generator
) -> tuple[str, float, int, Callable[[], PausableActors]]:
    """(description, density, people removed, factory of the actors): recorded people, if any, in half of the
    runs."""
    low, high = _PER_100M2
    density = float(low * (high / low) ** rng.random())
    attentive = float(rng.uniform(0.6, 1.0))
    if found.clips and rng.random() < 0.5:
        clip = found.clips[int(rng.integers(len(found.clips)))]
        from_s = float(rng.uniform(0.0, max(0.0, clip.ends_s - 40.0)))
        everyone, people = _placed(clip, points, rng)
        placed = _away_from_start(everyone, points[0], from_s)
        area_100m2 = 2.0 * _REACH_M * float(arc_lengths(points)[-1]) / 100.0
        return (
            f"replayed {clip.name}",
            people / area_100m2,
            len(everyone.tracks) - len(placed.tracks),
            lambda: ReplayedTraffic(placed, from_s, appear_m=_APPEAR_M),
        )
    params = CrowdParams(density, attentive, _REACH_M)
    return "reactive", density, 0, lambda: SocialCrowd(params, points, seed)


def _placed(clip: Clip, points: Array, rng: np.random.Generator) -> tuple[Clip, float]:
    """The recorded people without cars, rotated and moved onto the middle of the path; their mean number."""
    people = [track for track in clip.tracks if track.kind == PEDESTRIAN]
    places = np.vstack([track.states[:, :2] for track in people])
    middle, target = places.mean(axis=0), points[len(points) // 2]
    turn = float(rng.uniform(-math.pi, math.pi))
    cos, sin = math.cos(turn), math.sin(turn)
    rotation = np.array([[cos, -sin], [sin, cos]])
    moved = []
    for track in people:
        states = track.states.copy()
        states[:, :2] = (states[:, :2] - middle) @ rotation.T + target
        states[:, 2] += turn
        states[:, 3:5] = states[:, 3:5] @ rotation.T
        moved.append(_extended(replace(track, states=states)))
    present_s = sum(float(track.times_s[-1] - track.times_s[0]) for track in people)
    return Clip(clip.name, tuple(moved), clip.ends_s), present_s / max(clip.ends_s, 1e-9)


def _extended(track: RecordedTrack) -> RecordedTrack:
    """The track extended by _EDGE_S at both ends: people enter and leave the picture at constant velocity."""
    times, states = track.times_s, track.states
    first, last = states[0].copy(), states[-1].copy()
    first[:2] -= _EDGE_S * first[3:5]
    last[:2] += _EDGE_S * last[3:5]
    return replace(
        track,
        times_s=np.concatenate(([times[0] - _EDGE_S], times, [times[-1] + _EDGE_S])),
        states=np.vstack((first, states, last)),
    )


def _away_from_start(clip: Clip, start: Array, from_s: float) -> Clip:
    """The clip without people who would appear beside the shuttle when the run begins."""
    tracks = []
    for track in clip.tracks:
        there = track.times_s[0] <= from_s <= track.times_s[-1]
        x, y = (np.interp(from_s, track.times_s, track.states[:, k]) for k in (0, 1))
        if not there or math.hypot(x - start[0], y - start[1]) > _CLEAR_M:
            tracks.append(track)
    return replace(clip, tracks=tuple(tracks))
