"""Scans and proposed point maps as the use cases see them."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Protocol

from server.domain.fleet.scans import MapProposal, ScanContribution, ScanParcel, ScanRequest

# When it was started, and its id.
ScanPosition = tuple[datetime, str]


class ScanRepository(Protocol):
    def request(self, request_id: str) -> ScanRequest | None: ...

    def open_at(self, now: datetime) -> tuple[ScanRequest, ...]:
        """Oldest first."""
        ...

    def newest_requests(self, limit: int, after: ScanPosition | None = None) -> tuple[ScanRequest, ...]: ...

    def save_request(self, request: ScanRequest) -> None: ...

    def contributions(self, request_id: str) -> tuple[ScanContribution, ...]:
        """By vehicle."""
        ...

    def save_contribution(self, contribution: ScanContribution) -> None: ...

    def parcel(self, sha256: str) -> ScanParcel | None: ...

    def parcels(self, request_id: str) -> tuple[ScanParcel, ...]:
        """By vehicle, drive and number."""
        ...

    def add_parcel(self, parcel: ScanParcel) -> None: ...

    def remove_parcel(self, sha256: str) -> None:
        """A hash that is not known changes nothing."""
        ...

    def parcels_ended_before(
        self, moment: datetime, but_of: frozenset[str], limit: int
    ) -> tuple[ScanParcel, ...]:
        """Of requests that were over by then, in order of arrival. but_of: ids of requests to leave out."""
        ...

    def proposal(self, proposal_id: str) -> MapProposal | None: ...

    def proposals_under_way(self) -> tuple[MapProposal, ...]:
        """Oldest first."""
        ...

    def newest_proposals(self, limit: int, after: ScanPosition | None = None) -> tuple[MapProposal, ...]: ...

    def save_proposal(self, proposal: MapProposal) -> None: ...

    def results_decided_before(self, moment: datetime, limit: int) -> tuple[MapProposal, ...]:
        """With files, published or dismissed before then; the oldest decision first."""
        ...

    def proposals_of_result(self, sha256: str) -> tuple[MapProposal, ...]: ...


class MapBuildRefused(Exception):
    """The scans make no map, or the work has failed; the message is one sentence."""


class MapBuilder(Protocol):
    """Makes a point map of parcels in a child process."""

    async def build(
        self, parcels: Path, in_force: Path | None, out: Path, tell: Callable[[str, int], None]
    ) -> None:
        """Fills the new folder `out`. tell: stage and percent. Cancelling ends the child.

        Raises MapBuildRefused.
        """
        ...
