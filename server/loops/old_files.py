"""Deletes files that are kept for some days: the bytes, then the entry, so that none is left without one."""

from collections.abc import Callable
from functools import partial

import structlog

from server.store.segments.segment_store import SegmentStore, SegmentStoreError
from server.supervision.standing_tasks import PeriodicTask
from server.usecases.ports.offload import Offload
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

log = structlog.get_logger("loops")

PERIOD_S = 3600.0


class OldFilesLoop:
    """what: "videos" or "scans".

    outdated  hashes of some files that are too old, the oldest first; forget: deletes the entry of one
    """

    def __init__(
        self,
        what: str,
        transactions: Transactions,
        offload: Offload,
        store: SegmentStore,
        outdated: Callable[[UnitOfWork], tuple[str, ...]],
        forget: Callable[[UnitOfWork, str], None],
    ) -> None:
        self._what, self._transactions, self._offload, self._store = what, transactions, offload, store
        self._outdated, self._forget = outdated, forget
        self.task = PeriodicTask(f"old_{what}", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        """Some hundred at a time, until none is old. A store that fails is tried again in the next hour."""
        while old := await self._transactions.read(self._outdated):
            for sha256 in old:
                try:
                    await self._offload.run(partial(self._store.remove, sha256))
                except (SegmentStoreError, OSError) as error:
                    log.warning("file.not_deleted", what=self._what, sha256=sha256, error=str(error))
                    return
                await self._forgotten(sha256)
            log.info("files.deleted", what=self._what, files=len(old))

    async def _forgotten(self, sha256: str) -> None:
        await self._transactions.run(lambda uow: self._forget(uow, sha256))
