"""The perception worker as a process: scans in, percepts out, for one vehicle or several simulated ones."""

import signal
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import structlog

from vehicle_agent.device_feed import DatagramPort, DeviceFeedError, ScanReady, ScanRing
from vehicle_agent.perception.own_tracks import TracksWorker
from vehicle_agent.perception.people_worker import PeopleWorker
from vehicle_agent.perception.worker import PerceptionWorker
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import Deliveries, Delivery, Mailbox, TickMotion
from vehicle_agent.runtime.processes.sensing.below_memory import BelowMemory
from vehicle_agent.runtime.processes.sensing.people_feed import PeopleFeed

log = structlog.get_logger()

# For the run log and for operators who look.
THINNED_SOURCE = "thinned scans"
WAIT_NS = 500_000_000
# A scan's percepts may take so long where all processes share a clock that waits for them; in virtual time
# they always do.
WORK_NS = 40_000_000
# While percepts wait for room at their reader.
RETRY_NS = 10_000_000
# No datagram tells of the scans of a scanner for people, and of pictures.
PEOPLE_EVERY_NS = 20_000_000


@dataclass(frozen=True, slots=True)
class ScannedVehicle:
    """mail: the folder of the vehicle's mailboxes. signs: None for a stack that reads no signs."""

    vehicle_id: str
    mail: Path
    scans_port: int
    scan_ring: Path
    perception: PerceptionWorker


class _Feed:
    """One vehicle's scans. The ring is opened with the first scan, since the driver creates it."""

    def __init__(self, vehicle: ScannedVehicle, clock: Clock) -> None:
        self.vehicle = vehicle
        self._clock = clock
        self.port = DatagramPort(vehicle.scans_port)
        self.mailbox = Mailbox(vehicle.mail / "worker")
        self._ring: ScanRing | None = None
        self._left_out = 0
        self._below: BelowMemory | None = None
        if isinstance(vehicle.perception, TracksWorker):
            self._below = BelowMemory(vehicle.vehicle_id, vehicle.mail, vehicle.perception)
        self.people: PeopleFeed | None = None
        if isinstance(vehicle.perception, PeopleWorker):
            self.people = PeopleFeed(vehicle.vehicle_id, vehicle.perception, vehicle.scan_ring)

    def process_newest(self) -> None:
        """Takes the vehicle's motions, and processes the newest scans; older ones are skipped."""
        for mail in self.mailbox.take():
            if isinstance(mail, TickMotion):
                self.vehicle.perception.take(mail.motion)
        if self.people is not None:
            self.people.take(self._clock.now_ns())
        announced = [datagram for datagram in self.port.take() if isinstance(datagram, ScanReady)]
        if announced:
            self._answer(announced[-1])

    def _answer(self, ready: ScanReady) -> None:
        try:
            self._ring = self._ring or ScanRing(self.vehicle.scan_ring, create=False)
        except DeviceFeedError as error:
            log.warning("worker.no_scans", vehicle_id=self.vehicle.vehicle_id, error=str(error))
            return
        rows = self._ring.read_rows(ready)
        if rows is None:
            # The driver has created a new ring, or the scan was overwritten: the next scan decides.
            self._ring = None
            return
        if ready.left_out and not self._left_out:
            log.warning("worker.points_left_out", vehicle_id=self.vehicle.vehicle_id, points=ready.left_out)
        self._left_out = ready.left_out
        self._clock.work(ready.stamp_ns + WORK_NS)
        percepts = self.vehicle.perception.percepts(rows, ready.stamp_ns)
        now_ns = self._clock.now_ns()
        deliveries = Deliveries(tuple(Delivery(now_ns, "worker", percept) for percept in percepts))
        # The gate gets percepts directly, so that an error of the tick does not reach it.
        for reader in ("tick", "gate"):
            self.mailbox.post(self.vehicle.mail / reader, deliveries)
        if self._below is not None:
            self._below.keep()
        # After the obstacles, which are waited for more urgently.
        signs = self.vehicle.perception.signs(rows, ready.stamp_ns)
        if signs:
            now_ns = self._clock.now_ns()
            read = Deliveries(tuple(Delivery(now_ns, "worker", percept) for percept in signs))
            self.mailbox.post(self.vehicle.mail / "tick", read)
        thinned = self.vehicle.perception.thinned(rows, ready.stamp_ns)
        if thinned is not None:
            shown = Delivery(self._clock.now_ns(), THINNED_SOURCE, thinned)
            self.mailbox.post(self.vehicle.mail / "tick", Deliveries((shown,)))

    def close(self) -> None:
        self.port.close()
        self.mailbox.close()


def serve_percepts(vehicles: tuple[ScannedVehicle, ...], clock: Clock) -> None:
    """Until SIGTERM."""
    stopping = False

    def stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopping
        stopping = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    feeds = [_Feed(vehicle, clock) for vehicle in vehicles]
    files = [feed.port.fileno() for feed in feeds]
    every_ns = PEOPLE_EVERY_NS if any(feed.people is not None for feed in feeds) else WAIT_NS
    while not stopping:
        has_waiting = any(feed.mailbox.has_waiting for feed in feeds)
        clock.wait(clock.now_ns() + (RETRY_NS if has_waiting else every_ns), files)
        for feed in feeds:
            feed.process_newest()
    for feed in feeds:
        feed.close()
