"""Point maps that are proposed of scans: made, looked at, published or dismissed by operators."""

import shutil
import tempfile
import zipfile
from pathlib import Path as FilePath
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Response

from contract.scan_parcels.proposals import PICTURE
from server.api.commands import DrawCommand, PublishCommand
from server.api.formats import NAME_PATTERN
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import ScanStoreUnavailable, TileStoreUnavailable, problems
from server.api.scans.routes import ScanRequestId
from server.api.scans.schemas import Decision, ProposalView, proposal_view
from server.api.security.access import (
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    SECOND_FACTOR_REFUSALS,
    Reader,
)
from server.api.services import InjectedServices, Services
from server.domain.errors import (
    CampusUnknown,
    LocalizationMapElsewhere,
    LocalizationMapIncomplete,
    LocalizationMapInvalid,
    LocalizationMapUnknown,
    LocalizationTileInvalid,
    NoScansYet,
    ProposalNotReady,
    ProposalOutdated,
    ProposalUnderWay,
    ProposalUnknown,
    ScanMapsUnavailable,
    ScanRequestUnknown,
    TooManyLocalizationMaps,
)
from server.domain.fleet.scans import MapProposal
from server.store.segments.localization_folder import store_folder
from server.store.segments.segment_store import SegmentStoreError
from server.usecases.fleet import map_proposals
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

router = APIRouter(tags=["scans"])

ProposalId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["proposal-2"])]
_BINARY = {"schema": {"type": "string", "format": "binary"}}
ZIP: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "The map's folder, its figures and its picture.",
        "content": {"application/zip": _BINARY},
    }
}
PNG: dict[int | str, dict[str, Any]] = {
    200: {"description": "Both maps from above, changes in colours.", "content": {"image/png": _BINARY}}
}
# A proposal's files never change.
_CACHE = {"Cache-Control": "private, max-age=86400, immutable"}


@router.post(
    "/scan-requests/{request_id}/maps",
    operation_id="propose_map",
    status_code=202,
    responses=problems(
        ScanRequestUnknown, NoScansYet, ProposalUnderWay, ScanMapsUnavailable, *OPERATOR_REFUSALS
    ),
)
async def propose_map(
    request_id: ScanRequestId, services: InjectedServices, command: DrawCommand
) -> ProposalView:
    """Make a point map of all scans that have come, and compare it with the one in force. Minutes pass."""
    if not services.makes_maps:
        raise ScanMapsUnavailable("this installation makes no point maps: no server process of it can")
    return await command.transact(
        ProposalView, lambda uow: _view(uow, map_proposals.ask_for_map(uow, request_id, command.by))
    )


@router.get("/map-proposals", operation_id="list_map_proposals", responses=paged(*READER_REFUSALS))
async def list_map_proposals(
    services: InjectedServices, _: Reader, page: Page, limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 50
) -> list[ProposalView]:
    """Newest first."""
    ended = page.after(int, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]))

    def work(uow: UnitOfWork) -> list[ProposalView]:
        return [_view(uow, one) for one in uow.scans.newest_proposals(limit + 1, after)]

    found = await services.transactions.read(work)
    return page.first(found, limit, lambda one: (microseconds_of(one.started_at), one.proposal_id))


@router.get(
    "/map-proposals/{proposal_id}",
    operation_id="get_map_proposal",
    responses=problems(ProposalUnknown, *READER_REFUSALS),
)
async def get_map_proposal(proposal_id: ProposalId, services: InjectedServices, _: Reader) -> ProposalView:
    return await services.transactions.read(
        lambda uow: _view(uow, map_proposals.proposal_of(uow, proposal_id))
    )


@router.get(
    "/map-proposals/{proposal_id}/picture",
    operation_id="get_map_proposal_picture",
    response_class=Response,
    responses=problems(ProposalUnknown, ProposalNotReady, ScanStoreUnavailable, *READER_REFUSALS) | PNG,
)
async def get_map_proposal_picture(
    proposal_id: ProposalId, services: InjectedServices, _: Reader
) -> Response:
    path = await _result(services, proposal_id)

    def picture() -> bytes:
        with zipfile.ZipFile(path) as file:
            return file.read(PICTURE)

    return Response(await services.offload.run(picture), media_type="image/png", headers=_CACHE)


@router.get(
    "/map-proposals/{proposal_id}/map",
    operation_id="get_map_proposal_file",
    response_class=Response,
    responses=problems(ProposalUnknown, ProposalNotReady, ScanStoreUnavailable, *READER_REFUSALS) | ZIP,
)
async def get_map_proposal_file(proposal_id: ProposalId, services: InjectedServices, _: Reader) -> Response:
    """As a file, e.g. to try it on one vehicle with `campusloop agent point-map`."""
    path = await _result(services, proposal_id)
    headers = {"Content-Disposition": f'attachment; filename="{proposal_id}.zip"', **_CACHE}
    content = await services.offload.run(path.read_bytes)
    return Response(content, media_type="application/zip", headers=headers)


@router.post(
    "/map-proposals/{proposal_id}/stop",
    operation_id="stop_map_proposal",
    responses=problems(ProposalUnknown, ProposalNotReady, *OPERATOR_REFUSALS),
)
async def stop_map_proposal(proposal_id: ProposalId, command: DrawCommand) -> ProposalView:
    """End the work. The child process ends within some seconds."""
    return await command.transact(
        ProposalView, lambda uow: _view(uow, map_proposals.stop(uow, proposal_id, command.by))
    )


@router.post(
    "/map-proposals/{proposal_id}/publication",
    operation_id="publish_map_proposal",
    responses=problems(
        ProposalUnknown,
        ProposalNotReady,
        ProposalOutdated,
        ScanStoreUnavailable,
        TileStoreUnavailable,
        LocalizationMapInvalid,
        LocalizationTileInvalid,
        LocalizationMapElsewhere,
        LocalizationMapIncomplete,
        LocalizationMapUnknown,
        TooManyLocalizationMaps,
        CampusUnknown,
        *OPERATOR_REFUSALS,
        *SECOND_FACTOR_REFUSALS,
    ),
)
async def publish_map_proposal(
    proposal_id: ProposalId, body: Decision, services: InjectedServices, command: PublishCommand
) -> ProposalView:
    """Put the proposed map in force. Vehicles fetch it, and change over while they stand."""

    async def publish(transactions: Transactions) -> ProposalView:
        await _store_tiles(services, proposal_id, body.note, command.by)

        def work(uow: UnitOfWork) -> ProposalView:
            return _view(uow, map_proposals.publish(uow, proposal_id, body.note, command.by))

        return await transactions.run(work)

    return await command.about(proposal_id, body.note).call(ProposalView, publish, lambda view: view)


@router.post(
    "/map-proposals/{proposal_id}/dismissal",
    operation_id="dismiss_map_proposal",
    responses=problems(ProposalUnknown, ProposalNotReady, *OPERATOR_REFUSALS),
)
async def dismiss_map_proposal(proposal_id: ProposalId, body: Decision, command: DrawCommand) -> ProposalView:
    """The map in force stays."""

    def work(uow: UnitOfWork) -> ProposalView:
        return _view(uow, map_proposals.dismiss(uow, proposal_id, body.note, command.by))

    return await command.about(proposal_id, body.note).transact(ProposalView, work)


async def _store_tiles(services: Services, proposal_id: str, note: str, by: str) -> None:
    """The proposed map as a complete version beside the one in force; a repeat changes nothing.

    Of one that cannot be published nothing is stored: the transaction that follows says why, or that it was.
    """
    proposal = await services.transactions.read(lambda uow: map_proposals.proposal_of(uow, proposal_id))
    if proposal.state != "ready":
        return
    await services.transactions.read(lambda uow: map_proposals.publishable(uow, proposal_id))
    path = await _fetched(services, proposal)
    folder = FilePath(await services.offload.run(lambda: tempfile.mkdtemp(prefix="campusloop-proposal-")))
    try:
        await services.offload.run(lambda: _unpack(path, folder))
        await store_folder(services.transactions, services.tiles, services.offload, folder, by, note)
    except SegmentStoreError as error:
        raise TileStoreUnavailable(str(error)) from error
    except OSError as error:
        raise ScanStoreUnavailable(f"the map cannot be unpacked now: {error}") from error
    finally:
        await services.offload.run(lambda: shutil.rmtree(folder, ignore_errors=True))


async def _result(services: Services, proposal_id: str) -> FilePath:
    """The proposal's file. Raises ProposalUnknown, ProposalNotReady, ScanStoreUnavailable."""
    proposal = await services.transactions.read(lambda uow: map_proposals.proposal_of(uow, proposal_id))
    return await _fetched(services, proposal)


async def _fetched(services: Services, proposal: MapProposal) -> FilePath:
    if not proposal.result_sha256:
        was_made = bool(proposal.comparison)
        why = "its files were deleted with time; its figures are kept" if was_made else "there is no map"
        raise ProposalNotReady(f"{why}: it is {proposal.state}")
    try:
        path = await services.offload.run(lambda: services.scans.fetch(proposal.result_sha256))
    except (SegmentStoreError, OSError) as error:
        raise ScanStoreUnavailable(str(error)) from error
    if path is None:
        raise ScanStoreUnavailable("the files of this proposal are no longer kept; make it again")
    return path


def _unpack(path: FilePath, folder: FilePath) -> None:
    # Written by our own child process, with names of its own.
    with zipfile.ZipFile(path) as file:
        file.extractall(folder)


def _view(uow: UnitOfWork, proposal: MapProposal) -> ProposalView:
    request = uow.scans.request(proposal.request_id)
    return proposal_view(proposal, "" if request is None else request.name)
