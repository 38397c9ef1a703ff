"""The motion planner as a process: jobs in, trajectories out, for one vehicle."""

import gc
import signal
from collections.abc import Callable
from pathlib import Path
from types import FrameType

from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import (
    Deliveries,
    Delivery,
    Mailbox,
    PlannerJobs,
)
from vehicle_agent.signals import PlanAnswer, PlanJob

WAIT_NS = 500_000_000


class PlannerProcess:
    """Answers the newest job only: an older one starts where the vehicle no longer is."""

    def __init__(self, mail: Path, planner: Callable[[PlanJob], PlanAnswer], clock: Clock) -> None:
        """mail: the folder of the vehicle's mailboxes."""
        self._mail = mail
        self._clock = clock
        self._mailbox = Mailbox(mail / "planner")
        self._planner = planner
        self._stopping = False

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        gc.collect()
        gc.freeze()
        while not self._stopping:
            self._clock.wait(self._clock.now_ns() + WAIT_NS, (self._mailbox.fileno(),))
            jobs = [
                job for mail in self._mailbox.take() if isinstance(mail, PlannerJobs) for job in mail.jobs
            ]
            if jobs:
                self._answer(jobs[-1])
        self._mailbox.close()

    def _answer(self, job: PlanJob) -> None:
        answer = self._planner(job)
        delivery = Delivery(self._clock.now_ns(), "planner", answer)
        self._mailbox.post(self._mail / "tick", Deliveries((delivery,)))

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True
