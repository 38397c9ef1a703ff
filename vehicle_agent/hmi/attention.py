"""Inattentive people: on the vehicle's way with the back to the vehicle, standing or walking (Snow Lion: the
sound player addresses pedestrians "who may be inattentive")."""

import math

import msgspec
import numpy as np

from contract.geometry import pose_at, project
from contract.roads.routing import ReferenceLine
from vehicle_agent.signals import PEDESTRIAN, Path, Task, World

# Only this piece of the line is searched: farther on, it may come back to here.
_LOOK_BEHIND_M = 2.0


class WatchedPerson(msgspec.Struct, frozen=True):
    """A person on the way with the back to the vehicle.

    since_ns, seen_ns  since when, and when last detected so
    asked_ns           when asked to step aside, 0 not yet
    """

    track_id: int
    since_ns: int
    seen_ns: int
    asked_ns: int = 0


class Attention(msgspec.Struct, frozen=True):
    """front_m, half_width_m  of the vehicle's outline about its rear axle
    ahead_m       people farther ahead of the bumper are not addressed
    beside_m      the way is wider than the outline by this on each side
    back_rad      a person faces away when the course is within this of the direction away from the vehicle
    walks_mps     a slower person's course is the track's heading, otherwise that of the velocity
    unaware_ns    a person who faces away this long is inattentive
    lost_ns       a tracker may miss a person for this long
    again_ns      a person is not asked twice within this time
    """

    front_m: float
    half_width_m: float
    ahead_m: float = 10.0
    beside_m: float = 0.3
    back_rad: float = 1.05
    walks_mps: float = 0.4
    unaware_ns: int = 3_000_000_000
    lost_ns: int = 600_000_000
    again_ns: int = 60_000_000_000

    def update(
        self, before: tuple[WatchedPerson, ...], task: Task, path: Path, world: World, now_ns: int
    ) -> tuple[WatchedPerson, ...]:
        """The people who face away now or did a moment ago, and those asked recently."""
        facing_away = set() if task.line is None else self._facing_away(task.line, task, path, world)
        after = []
        for person in before:
            if person.track_id in facing_away:
                facing_away.remove(person.track_id)
                # A person who was away and comes back starts again.
                is_new = now_ns - person.seen_ns > self.lost_ns
                after.append(
                    msgspec.structs.replace(
                        person, seen_ns=now_ns, since_ns=now_ns if is_new else person.since_ns
                    )
                )
            elif now_ns - person.seen_ns <= self.lost_ns or self._was_asked_recently(person, now_ns):
                after.append(person)
        after += [WatchedPerson(track_id, now_ns, now_ns) for track_id in sorted(facing_away)]
        return tuple(after)

    def unaware(self, watched: tuple[WatchedPerson, ...], now_ns: int) -> tuple[int, ...]:
        """Ids of the people who are inattentive now."""
        return tuple(
            person.track_id
            for person in watched
            if now_ns - person.seen_ns <= self.lost_ns and person.seen_ns - person.since_ns >= self.unaware_ns
        )

    def unasked(self, watched: tuple[WatchedPerson, ...], now_ns: int) -> tuple[int, ...]:
        """Ids of the inattentive people who have not been asked recently."""
        recently = {person.track_id for person in watched if self._was_asked_recently(person, now_ns)}
        return tuple(track_id for track_id in self.unaware(watched, now_ns) if track_id not in recently)

    def with_asked(self, watched: tuple[WatchedPerson, ...], now_ns: int) -> tuple[WatchedPerson, ...]:
        """The people watched, after a sentence to all inattentive ones."""
        unaware = set(self.unaware(watched, now_ns))
        return tuple(
            msgspec.structs.replace(person, asked_ns=now_ns) if person.track_id in unaware else person
            for person in watched
        )

    def _was_asked_recently(self, person: WatchedPerson, now_ns: int) -> bool:
        return person.asked_ns > 0 and now_ns - person.asked_ns < self.again_ns

    def _facing_away(self, line: ReferenceLine, task: Task, path: Path, world: World) -> set[int]:
        """Ids of the people on the way who face away, by the current tracks."""
        tracks = world.tracks
        people = np.flatnonzero(tracks.kinds == PEDESTRIAN)
        if not len(people):
            return set()
        first = int(np.searchsorted(line.s, task.s_m - _LOOK_BEHIND_M))
        last = int(np.searchsorted(line.s, task.s_m + self.front_m + self.ahead_m + 2.0)) + 1
        x_m, y_m, yaw_rad = pose_at(line.points, line.s, task.s_m)
        x_m, y_m = x_m - task.d_m * math.sin(yaw_rad), y_m + task.d_m * math.cos(yaw_rad)
        track_ids = set()
        for i in people:
            px, py, heading_rad = tracks.poses_map[i]
            s_m, d_m, _ = project(line.points, line.s, float(px), float(py), first, last)
            gap_m = s_m - task.s_m - self.front_m
            is_yielded_to = int(tracks.ids[i]) in path.yields_to
            reach_m = self.half_width_m + self.beside_m * (2.0 if is_yielded_to else 1.0)
            if not 0.0 <= gap_m <= self.ahead_m or abs(d_m - task.d_m) > reach_m:
                continue
            vx, vy = tracks.velocities_map_mps[i]
            course_rad = math.atan2(vy, vx) if math.hypot(vx, vy) > self.walks_mps else float(heading_rad)
            away_rad = math.atan2(py - y_m, px - x_m)
            if math.cos(course_rad - away_rad) > math.cos(self.back_rad):
                track_ids.add(int(tracks.ids[i]))
        return track_ids
