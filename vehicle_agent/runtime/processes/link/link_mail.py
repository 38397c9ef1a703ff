"""The tick's mail to the link, which may be away: it starts later than the tick, it is killed, it hangs.

What the server must learn waits here meanwhile: events, answers, the mission's memory. Run-log entries don't:
a segment without its beginning is worth nothing, so another one begins when the link is back.
"""

from collections import deque
from collections.abc import Sequence
from pathlib import Path

import msgspec
import structlog

from vehicle_agent.link.bridge import TickUpdate
from vehicle_agent.runtime.processes.mailbox import WAITING_MAX, Mail, Mailbox, TickReport
from vehicle_agent.runtime.recording.recorder import RunLogEntry

log = structlog.get_logger()

# Of those kept, with each tick. The link writes each to disk before it takes the next.
UPDATES_A_TICK = 5
# Hours of a drive. A link that stays away for longer loses the oldest, and the log says so.
UPDATES_KEPT_MAX = 5_000


class LinkMail:
    """Posts each tick's report. Give `note_lost` every mail that the mailbox lost."""

    def __init__(self, mailbox: Mailbox, link: Path) -> None:
        """link: the path of the link's mailbox."""
        self._mailbox, self._link = mailbox, link
        self._is_away = False
        self._lost: list[TickUpdate] = []
        self._kept: deque[TickUpdate] = deque()

    def note_lost(self, mail: Mail) -> None:
        if isinstance(mail, TickReport):
            self._go_away()
            if mail.update is not None:
                self._lost.append(mail.update)

    def post(self, update: TickUpdate | None, entries: Sequence[RunLogEntry]) -> bool:
        """Posts a tick's report; True: the link is back, and the run log shall begin a segment."""
        self._keep_lost()
        if self._mailbox.waiting_for(self._link) >= WAITING_MAX:
            self._go_away()
        if self._is_away:
            self._keep(update)
            return self._is_back()
        if self._kept:
            self._keep(update)
            update = (
                None if update is None else TickUpdate(update.stamp_ns, update.report, scene=update.scene)
            )
            self._post_kept()
        if update is not None or entries:
            self._mailbox.post(self._link, TickReport(update, tuple(entries)))
        return False

    def _post_kept(self) -> None:
        """Posts the oldest, when the link has room: what waits for room beyond `WAITING_MAX` is lost."""
        if self._mailbox.waiting_for(self._link):
            return
        for _ in range(min(UPDATES_A_TICK, len(self._kept))):
            self._mailbox.post(self._link, TickReport(self._kept.popleft(), ()))

    def _go_away(self) -> None:
        if not self._is_away:
            self._is_away = True
            log.warning("link.away", kept="events, answers and memory", not_kept="the recording")

    def _is_back(self) -> bool:
        """Whether an empty report reaches the link, behind all that has waited for room."""
        if self._mailbox.waiting_for(self._link) or not self._mailbox.post(self._link, TickReport(None, ())):
            return False
        self._is_away = self._mailbox.waiting_for(self._link) > 0
        if not self._is_away:
            log.info("link.back", kept_updates=len(self._kept))
        return not self._is_away

    def _keep_lost(self) -> None:
        """Puts lost updates before those that were never posted: they are older."""
        if not self._lost:
            return
        younger, self._kept = self._kept, deque()
        for update in self._lost:
            self._keep(update)
        self._kept.extend(younger)
        self._lost = []

    def _keep(self, update: TickUpdate | None) -> None:
        """Keeps what the server must learn, with the time of its tick; a status is soon out of date."""
        if update is None or not (update.events or update.answers or update.memory is not None):
            return
        self._kept.append(msgspec.structs.replace(update, report=None, scene=None))
        if len(self._kept) > UPDATES_KEPT_MAX:
            lost = self._kept.popleft()
            log.error("link.update_lost", events=[type(event).__name__ for event in lost.events])
