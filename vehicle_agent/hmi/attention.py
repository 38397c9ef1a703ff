"""Who is in the way without knowing it: somebody on the vehicle's way who stands there, or walks away in it,
with the back to the vehicle (Snow Lion: the sound player addresses pedestrians "who may be inattentive")."""

import math

import msgspec
import numpy as np

from contract.geometry import pose_at, project
from contract.roads.routing import ReferenceLine
from vehicle_agent.signals import PEDESTRIAN, Path, Task, World

# A fork or a hairpin of the line farther on must not be taken for the way just ahead.
_LOOK_BEHIND_M = 2.0


class WatchedPerson(msgspec.Struct, frozen=True):
    """Somebody in the way with the back to the vehicle: since when, when last seen so, asked to step aside
    when (0: not yet)."""

    track_id: int
    since_ns: int
    seen_ns: int
    asked_ns: int = 0


class Attention(msgspec.Struct, frozen=True):
    """front_m, half_width_m  of the vehicle's outline about its rear axle
    ahead_m       nobody farther before the bumper is spoken to
    beside_m      how far beside the outline's way somebody is still in it
    back_rad      the back is turned when the course is within this of the direction away from the vehicle
    walks_mps     who is slower has the course of the track's heading, else of the velocity
    unaware_ns    this long with the back turned is inattentive
    lost_ns       a tracker may miss somebody for so long
    again_ns      nobody is asked twice within this time
    """

    front_m: float = 3.5
    half_width_m: float = 0.815
    ahead_m: float = 10.0
    beside_m: float = 0.3
    back_rad: float = 1.05
    walks_mps: float = 0.4
    unaware_ns: int = 3_000_000_000
    lost_ns: int = 600_000_000
    again_ns: int = 60_000_000_000

    def watch(
        self, before: tuple[WatchedPerson, ...], task: Task, path: Path, world: World, now_ns: int
    ) -> tuple[WatchedPerson, ...]:
        """Everybody who has the back turned now or did just now, and who was asked lately."""
        turned = set() if task.line is None else self._turned(task.line, task, path, world)
        after = []
        for one in before:
            if one.track_id in turned:
                turned.remove(one.track_id)
                # Somebody who comes back after having been away begins anew.
                fresh = now_ns - one.seen_ns > self.lost_ns
                after.append(
                    msgspec.structs.replace(one, seen_ns=now_ns, since_ns=now_ns if fresh else one.since_ns)
                )
            elif now_ns - one.seen_ns <= self.lost_ns or self._asked_lately(one, now_ns):
                after.append(one)
        after += [WatchedPerson(number, now_ns, now_ns) for number in sorted(turned)]
        return tuple(after)

    def unaware(self, watched: tuple[WatchedPerson, ...], now_ns: int) -> tuple[int, ...]:
        """Ids of those who are inattentive now."""
        return tuple(
            one.track_id
            for one in watched
            if now_ns - one.seen_ns <= self.lost_ns and one.seen_ns - one.since_ns >= self.unaware_ns
        )

    def unasked(self, watched: tuple[WatchedPerson, ...], now_ns: int) -> tuple[int, ...]:
        """Those of `unaware` who have not been asked lately."""
        lately = {one.track_id for one in watched if self._asked_lately(one, now_ns)}
        return tuple(number for number in self.unaware(watched, now_ns) if number not in lately)

    def asked(self, watched: tuple[WatchedPerson, ...], now_ns: int) -> tuple[WatchedPerson, ...]:
        """After a sentence to all who are unaware now."""
        heard = set(self.unaware(watched, now_ns))
        return tuple(
            msgspec.structs.replace(one, asked_ns=now_ns) if one.track_id in heard else one for one in watched
        )

    def _asked_lately(self, one: WatchedPerson, now_ns: int) -> bool:
        return one.asked_ns > 0 and now_ns - one.asked_ns < self.again_ns

    def _turned(self, line: ReferenceLine, task: Task, path: Path, world: World) -> set[int]:
        """Ids of people in the way with the back turned, by the tracks of now."""
        tracks = world.tracks
        people = np.flatnonzero(tracks.kinds == PEDESTRIAN)
        if not len(people):
            return set()
        first = int(np.searchsorted(line.s, task.s_m - _LOOK_BEHIND_M))
        last = int(np.searchsorted(line.s, task.s_m + self.front_m + self.ahead_m + 2.0)) + 1
        x_m, y_m, yaw_rad = pose_at(line.points, line.s, task.s_m)
        x_m, y_m = x_m - task.d_m * math.sin(yaw_rad), y_m + task.d_m * math.cos(yaw_rad)
        found = set()
        for i in people:
            px, py, heading_rad = tracks.poses_map[i]
            s_m, d_m, _ = project(line.points, line.s, float(px), float(py), first, last)
            gap_m = s_m - task.s_m - self.front_m
            named = int(tracks.ids[i]) in path.yields_to
            reach_m = self.half_width_m + self.beside_m * (2.0 if named else 1.0)
            if not 0.0 <= gap_m <= self.ahead_m or abs(d_m - task.d_m) > reach_m:
                continue
            vx, vy = tracks.velocities_map_mps[i]
            course_rad = math.atan2(vy, vx) if math.hypot(vx, vy) > self.walks_mps else float(heading_rad)
            away_rad = math.atan2(py - y_m, px - x_m)
            if math.cos(course_rad - away_rad) > math.cos(self.back_rad):
                found.add(int(tracks.ids[i]))
        return found
