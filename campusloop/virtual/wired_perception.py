"""The perception worker of a simulated vehicle: scans and pictures in, percepts out when they are due."""

import time
from collections import deque

import numpy as np

from campusloop.virtual.conductor import STEP_NS
from simulator.world import SimWorld
from vehicle_agent.config import Profile
from vehicle_agent.perception.people_worker import PeopleWorker
from vehicle_agent.signals import Percept, SignPercept, ThinnedScan
from vehicle_agent.signals.objects import EgoMotion
from vehicle_agent.stacks.choice import build_perception_worker

# The worker's time for one scan, with the transport there and back.
PERCEPT_DELAY_NS = 2 * STEP_NS


class WiredPerception:
    """A picture is looked at between two scans, within the worker's modelled time for the second.

    cpu_ms  of the percepts of each scan so far, with the planar scans and pictures since the one before
    """

    def __init__(self, vehicle_id: str, profile: Profile, world: SimWorld) -> None:
        self._vehicle_id, self._world = vehicle_id, world
        self._worker = build_perception_worker(profile)
        self._due: deque[tuple[int, Percept | SignPercept | ThinnedScan]] = deque()
        self._cpu_s = 0.0
        self.cpu_ms: list[float] = []

    def crash(self) -> None:
        """What is on its way is lost."""
        self._due.clear()

    def take(self, motion: EgoMotion) -> None:
        self._worker.take(motion)

    def see(self, scan: tuple[np.ndarray, np.ndarray] | None, now_ns: int) -> None:
        """Look at what people's sensors show in this step, and at the lidar's scan if there is one."""
        if isinstance(self._worker, PeopleWorker):
            self._look_for_people(self._worker, now_ns)
        if scan is None:
            return
        began_s = time.process_time()
        rows = _rows(scan)
        for percept in self._worker.percepts(rows, now_ns):
            self._due.append((now_ns + PERCEPT_DELAY_NS, percept))
        for signs in self._worker.signs(rows, now_ns):
            self._due.append((now_ns + PERCEPT_DELAY_NS, signs))
        self.cpu_ms.append(1e3 * (self._cpu_s + time.process_time() - began_s))
        self._cpu_s = 0.0
        thinned = self._worker.thinned(rows, now_ns)
        if thinned is not None:
            self._due.append((now_ns + PERCEPT_DELAY_NS, thinned))

    def due(self, now_ns: int) -> list[Percept | SignPercept | ThinnedScan]:
        """The percepts that have arrived."""
        found = []
        while self._due and self._due[0][0] <= now_ns:
            found.append(self._due.popleft()[1])
        return found

    def _look_for_people(self, worker: PeopleWorker, now_ns: int) -> None:
        planar = self._world.people_scan(self._vehicle_id, now_ns)
        began_s = time.process_time()
        if planar is not None:
            worker.planar(_rows(planar), now_ns)
        self._cpu_s += time.process_time() - began_s
        picture = self._world.picture(self._vehicle_id, now_ns, lambda: worker.windows(now_ns))
        began_s = time.process_time()
        if picture is not None:
            worker.look(picture)
        self._cpu_s += time.process_time() - began_s


def _rows(scan: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """(n, 5) as the scan ring has them; the simulated driver has moved all points to the stamp."""
    return np.column_stack((*scan, np.zeros_like(scan[1])))
