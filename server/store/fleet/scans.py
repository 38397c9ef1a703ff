"""Requests for scans, parcels and proposals as rows; the bytes of parcels and maps are in files."""

from datetime import datetime

from sqlalchemy import func, select

from server.domain.fleet.scans import Corner, MapProposal, ScanContribution, ScanParcel, ScanRequest
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.keyset import rows_after
from server.store.repository import AnyRow, Repository
from server.usecases.ports.scans import ScanPosition

_request = tables.scan_requests.c
_contribution = tables.scan_contributions.c
_parcel = tables.scan_parcels.c
_proposal = tables.map_proposals.c


class SqlScanRepository(Repository):
    def request(self, request_id: str) -> ScanRequest | None:
        row = self._find(tables.scan_requests, request_id=request_id)
        return None if row is None else _request_from_row(row)

    def open_at(self, now: datetime) -> tuple[ScanRequest, ...]:
        chosen = self._select(tables.scan_requests, _request.ended_at.is_(None), _request.until > now)
        ordered = chosen.order_by(_request.started_at, _request.request_id)
        return tuple(_request_from_row(row) for row in self._many(ordered))

    def newest_requests(self, limit: int, after: ScanPosition | None = None) -> tuple[ScanRequest, ...]:
        statement = self._select(tables.scan_requests)
        if after is not None:
            order = ((_request.started_at, True), (_request.request_id, True))
            statement = statement.where(rows_after(order, after))
        ordered = statement.order_by(_request.started_at.desc(), _request.request_id.desc())
        return tuple(_request_from_row(row) for row in self._many(ordered.limit(limit)))

    def save_request(self, request: ScanRequest) -> None:
        self._put(
            tables.scan_requests,
            {
                "request_id": request.request_id,
                "name": request.name,
                "outline": to_json(request.outline),
                "every_m": request.every_m,
                "bytes_max": request.bytes_max,
                "until": request.until,
                "started_at": request.started_at,
                "started_by": request.started_by,
                "ended_at": request.ended_at,
                "ended_by": request.ended_by,
                "end_reason": request.end_reason,
            },
        )

    def contributions(self, request_id: str) -> tuple[ScanContribution, ...]:
        chosen = self._select(tables.scan_contributions, _contribution.request_id == request_id)
        return tuple(
            _contribution_from_row(row) for row in self._many(chosen.order_by(_contribution.vehicle_id))
        )

    def save_contribution(self, contribution: ScanContribution) -> None:
        self._put(
            tables.scan_contributions,
            {
                "request_id": contribution.request_id,
                "vehicle_id": contribution.vehicle_id,
                "state": contribution.state,
                "detail": contribution.detail,
                "scans": contribution.scans,
                "way_m": contribution.way_m,
                "bytes_kept": contribution.bytes_kept,
                "reported_at": contribution.reported_at,
            },
        )

    def parcel(self, sha256: str) -> ScanParcel | None:
        row = self._find(tables.scan_parcels, sha256=sha256)
        return None if row is None else _parcel_from_row(row)

    def parcels(self, request_id: str) -> tuple[ScanParcel, ...]:
        chosen = self._select(tables.scan_parcels, _parcel.request_id == request_id)
        ordered = chosen.order_by(_parcel.vehicle_id, _parcel.drive_id, _parcel.number)
        return tuple(_parcel_from_row(row) for row in self._many(ordered))

    def add_parcel(self, parcel: ScanParcel) -> None:
        self._insert(
            tables.scan_parcels,
            {
                "sha256": parcel.sha256,
                "request_id": parcel.request_id,
                "vehicle_id": parcel.vehicle_id,
                "drive_id": parcel.drive_id,
                "number": parcel.number,
                "scans": parcel.scans,
                "way_m": parcel.way_m,
                "size_bytes": parcel.size_bytes,
                "received_at": parcel.received_at,
            },
        )

    def remove_parcel(self, sha256: str) -> None:
        self._delete(tables.scan_parcels, _parcel.sha256 == sha256)

    def parcels_ended_before(
        self, moment: datetime, but_of: frozenset[str], limit: int
    ) -> tuple[ScanParcel, ...]:
        # A request is over when it was ended, else at its time.
        over = select(_request.request_id).where(
            _request.campus_id == self._campus_id,
            _request.request_id.not_in(but_of),
            func.coalesce(_request.ended_at, _request.until) < moment,
        )
        chosen = self._select(tables.scan_parcels, _parcel.request_id.in_(over))
        ordered = chosen.order_by(_parcel.received_at, _parcel.sha256).limit(limit)
        return tuple(_parcel_from_row(row) for row in self._many(ordered))

    def proposal(self, proposal_id: str) -> MapProposal | None:
        row = self._find(tables.map_proposals, proposal_id=proposal_id)
        return None if row is None else _proposal_from_row(row)

    def proposals_under_way(self) -> tuple[MapProposal, ...]:
        chosen = self._select(tables.map_proposals, _proposal.state.in_(("queued", "building")))
        ordered = chosen.order_by(_proposal.started_at, _proposal.proposal_id)
        return tuple(_proposal_from_row(row) for row in self._many(ordered))

    def newest_proposals(self, limit: int, after: ScanPosition | None = None) -> tuple[MapProposal, ...]:
        statement = self._select(tables.map_proposals)
        if after is not None:
            order = ((_proposal.started_at, True), (_proposal.proposal_id, True))
            statement = statement.where(rows_after(order, after))
        ordered = statement.order_by(_proposal.started_at.desc(), _proposal.proposal_id.desc())
        return tuple(_proposal_from_row(row) for row in self._many(ordered.limit(limit)))

    def results_decided_before(self, moment: datetime, limit: int) -> tuple[MapProposal, ...]:
        chosen = self._select(
            tables.map_proposals, _proposal.decided_at < moment, _proposal.result_sha256 != ""
        )
        ordered = chosen.order_by(_proposal.decided_at, _proposal.proposal_id).limit(limit)
        return tuple(_proposal_from_row(row) for row in self._many(ordered))

    def proposals_of_result(self, sha256: str) -> tuple[MapProposal, ...]:
        chosen = self._select(tables.map_proposals, _proposal.result_sha256 == sha256)
        return tuple(_proposal_from_row(row) for row in self._many(chosen))

    def save_proposal(self, proposal: MapProposal) -> None:
        self._put(
            tables.map_proposals,
            {
                "proposal_id": proposal.proposal_id,
                "request_id": proposal.request_id,
                "started_at": proposal.started_at,
                "started_by": proposal.started_by,
                "state": proposal.state,
                "stage": proposal.stage,
                "percent": proposal.percent,
                "beat_at": proposal.beat_at,
                "detail": proposal.detail,
                "result_sha256": proposal.result_sha256,
                "comparison": proposal.comparison,
                "decided_at": proposal.decided_at,
                "decided_by": proposal.decided_by,
                "note": proposal.note,
            },
        )


def _request_from_row(row: AnyRow) -> ScanRequest:
    return ScanRequest(
        campus_id=row.campus_id,
        request_id=row.request_id,
        name=row.name,
        outline=from_json(row.outline, tuple[Corner, ...]),
        every_m=row.every_m,
        bytes_max=row.bytes_max,
        until=row.until,
        started_at=row.started_at,
        started_by=row.started_by,
        ended_at=row.ended_at,
        ended_by=row.ended_by,
        end_reason=row.end_reason,
    )


def _contribution_from_row(row: AnyRow) -> ScanContribution:
    return ScanContribution(
        request_id=row.request_id,
        vehicle_id=row.vehicle_id,
        state=row.state,
        detail=row.detail,
        scans=row.scans,
        way_m=row.way_m,
        bytes_kept=row.bytes_kept,
        reported_at=row.reported_at,
    )


def _parcel_from_row(row: AnyRow) -> ScanParcel:
    return ScanParcel(
        campus_id=row.campus_id,
        sha256=row.sha256,
        request_id=row.request_id,
        vehicle_id=row.vehicle_id,
        drive_id=row.drive_id,
        number=row.number,
        scans=row.scans,
        way_m=row.way_m,
        size_bytes=row.size_bytes,
        received_at=row.received_at,
    )


def _proposal_from_row(row: AnyRow) -> MapProposal:
    return MapProposal(
        campus_id=row.campus_id,
        proposal_id=row.proposal_id,
        request_id=row.request_id,
        started_at=row.started_at,
        started_by=row.started_by,
        state=row.state,
        stage=row.stage,
        percent=row.percent,
        beat_at=row.beat_at,
        detail=row.detail,
        result_sha256=row.result_sha256,
        comparison=row.comparison,
        decided_at=row.decided_at,
        decided_by=row.decided_by,
        note=row.note,
    )
