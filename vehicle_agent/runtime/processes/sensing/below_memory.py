"""Who stands below a vehicle's beams, kept for a perception worker that is started again.

A file in the folder of the vehicle's mailboxes, which is new with each start of the agent: after that nobody
knows who came or left.
"""

from pathlib import Path

import msgspec
import structlog

from vehicle_agent.perception.own_tracks import BelowBeams, TracksWorker

log = structlog.get_logger()

# A smaller move of who is there is not worth a write.
_STEP_M = 0.1


class BelowMemory:
    """Brings what the worker before knew into a new one, and keeps what this one knows."""

    def __init__(self, vehicle_id: str, folder: Path, worker: TracksWorker) -> None:
        """folder: of the vehicle's mailboxes. worker: before its first scan."""
        self._vehicle_id, self._worker = vehicle_id, worker
        self._path = folder / "below_beams.json"
        self._kept = _known(BelowBeams())
        self._failed = False
        self._bring()

    def _bring(self) -> None:
        """A file that cannot be read is told of and left out."""
        try:
            below = msgspec.json.decode(self._path.read_bytes(), type=BelowBeams)
        except FileNotFoundError:
            return
        except (OSError, msgspec.DecodeError) as error:
            log.error("worker.memory_unreadable", vehicle_id=self._vehicle_id, error=str(error))
            return
        self._worker.remember(below)
        self._kept = _known(below)
        if below.people_base:
            log.warning("worker.remembers", vehicle_id=self._vehicle_id, people_below=len(below.people_base))

    def keep(self) -> None:
        """After each scan. A full disk stops no percepts: it is told of once, until a write works again."""
        below = self._worker.below_beams()
        known = _known(below)
        if known == self._kept:
            return
        fresh = self._path.with_suffix(".new")
        try:
            fresh.write_bytes(msgspec.json.encode(below))
            fresh.replace(self._path)
        except OSError as error:
            if not self._failed:
                log.error("worker.memory_not_kept", vehicle_id=self._vehicle_id, error=str(error))
            self._failed = True
            return
        self._kept, self._failed = known, False


def _known(below: BelowBeams) -> tuple[int, list[tuple[int, ...]]]:
    people = [tuple(round(value / _STEP_M) for value in person) for person in below.people_base]
    return below.waved_on_ns, sorted(people)
