"""Deletes video that came long ago: its bytes, then its entry, so that no file is left without an entry."""

from functools import partial

import structlog

from server.store.segments.segment_store import SegmentStore, SegmentStoreError
from server.supervision.standing_tasks import PeriodicTask
from server.usecases.fleet import videos
from server.usecases.ports.offload import Offload
from server.usecases.ports.unit_of_work import Transactions

log = structlog.get_logger("loops")

PERIOD_S = 3600.0


class VideoRetentionLoop:
    def __init__(self, transactions: Transactions, offload: Offload, store: SegmentStore) -> None:
        self._transactions, self._offload, self._store = transactions, offload, store
        self.task = PeriodicTask("old_videos", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        """Some hundred at a time, until none is old. A store that fails is tried again in the next hour."""
        while old := await self._transactions.read(videos.outdated):
            for segment in old:
                try:
                    await self._offload.run(partial(self._store.remove, segment.sha256))
                except (SegmentStoreError, OSError) as error:
                    log.warning("video.not_deleted", sha256=segment.sha256, error=str(error))
                    return
                await self._transactions.run(partial(videos.forget, sha256=segment.sha256))
            log.info("video.deleted", segments=len(old))
