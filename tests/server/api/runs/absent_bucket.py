"""An object store that can be away."""

from dataclasses import replace
from pathlib import Path

from obstore.store import MemoryStore

from server.store.segments.bucket import SegmentBucket
from server.store.segments.incoming import IncomingSegment
from server.store.segments.segment_store import SegmentStoreError
from tests.server.api.server_under_test import ServerUnderTest


class AbsentBucket(SegmentBucket):
    is_away = False

    def has(self, sha256: str) -> bool:
        self._require()
        return super().has(sha256)

    def keep(self, incoming: IncomingSegment) -> None:
        self._require()
        super().keep(incoming)

    def fetch(self, sha256: str) -> Path | None:
        self._require()
        return super().fetch(sha256)

    def _require(self) -> None:
        if self.is_away:
            raise SegmentStoreError("the store of run segments is not usable now: away")


def use_bucket(server: ServerUnderTest) -> AbsentBucket:
    """The server keeps its segments in this bucket from now on."""
    bucket = AbsentBucket(MemoryStore(), server.settings.var_dir / "segments", 1 << 20)
    server.app.state.services = replace(server.services, segments=bucket)
    return bucket
