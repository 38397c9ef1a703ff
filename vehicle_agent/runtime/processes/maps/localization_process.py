"""The localization worker as a process: scans and the tick's jobs in, places on the map out, for one vehicle.

The tick's jobs wake it, 50 times a second. It then looks for a new scan in the scan ring: the driver tells
the perception worker alone of scans.
"""

import gc
import signal
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import structlog

from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import (
    Deliveries,
    Delivery,
    LocalizationJobs,
    LocalizationMapAnswer,
    Mailbox,
    MapAnswer,
)
from vehicle_agent.runtime.processes.sensing.new_scans import NewScans

log = structlog.get_logger()

WAIT_NS = 500_000_000
# What the room, the log and the inbox call the worker.
SOURCE = "localization"
# For the run log alone.
MATCHED_SOURCE = "matched scans"


class LocalizationProcess:
    """Answers the newest scan only: while it works on one, others come and go."""

    def __init__(
        self, mail: Path, scan_ring: Path, load: Callable[[], LocalizationWorker], clock: Clock
    ) -> None:
        """mail: the folder of the vehicle's mailboxes; load: a worker on the map that is in force then."""
        self._mail = mail
        self._clock = clock
        self._mailbox = Mailbox(mail / SOURCE)
        self._scans = NewScans(scan_ring)
        self._load = load
        self._worker = load()
        self._stopping = False

    def run(self, warm: Callable[[], None]) -> None:
        """Until SIGTERM. warm: loads the kernels before the first scan."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        warm()
        gc.collect()
        gc.freeze()
        while not self._stopping:
            self._clock.wait(self._clock.now_ns() + WAIT_NS, (self._mailbox.fileno(),))
            self.step()
        self._mailbox.close()

    def step(self) -> None:
        """Takes the jobs, and answers the newest scan if they reach it."""
        for mail in self._mailbox.take():
            if isinstance(mail, LocalizationJobs):
                for job in mail.jobs:
                    self._worker.take(job)
            elif isinstance(mail, LocalizationMapAnswer | MapAnswer) and mail.refusal is None:
                # The vehicle stands, so that the jobs of the last second may go with the former map.
                self._worker = self._load()
                log.info("localization.map_loaded")
        ready = self._scans.peek()
        if ready is None or not self._worker.is_ready(ready.stamp_ns):
            return
        cloud = self._scans.take(ready)
        answer = None if cloud is None or not len(cloud) else self._worker.answer(cloud)
        if answer is not None:
            now_ns, matched = self._clock.now_ns(), self._worker.take_matched()
            deliveries = [Delivery(now_ns, SOURCE, answer)]
            if matched is not None:
                deliveries.append(Delivery(now_ns, MATCHED_SOURCE, matched))
            self._mailbox.post(self._mail / "tick", Deliveries(tuple(deliveries)))

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True
