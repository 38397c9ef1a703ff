"""Point maps that are proposed of scans: asked for, made by a standing task, published or dismissed.

Nothing is published by itself: an operator looks at the figures and the picture, and decides.
"""

from dataclasses import replace

import msgspec

from contract.scan_parcels.proposals import Comparison
from server.domain.errors import (
    NoScansYet,
    ProposalNotReady,
    ProposalOutdated,
    ProposalUnderWay,
    ProposalUnknown,
)
from server.domain.fleet.scans import MapProposal, failed
from server.usecases.fleet import localization_maps
from server.usecases.fleet.scans import request_of
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import THE_SERVER, record_event

_SILENT = "the server that made it has ended; make it again"


def ask_for_map(uow: UnitOfWork, request_id: str, by: str) -> MapProposal:
    """A map of all scans of a request. Raises ScanRequestUnknown, NoScansYet, ProposalUnderWay."""
    request = request_of(uow, request_id)
    if not uow.scans.parcels(request_id):
        raise NoScansYet(f"no vehicle has sent scans for {request.name!r} yet")
    if any(one.request_id == request_id for one in uow.scans.proposals_under_way()):
        raise ProposalUnderWay(f"a map of the scans of {request.name!r} is being made already")
    proposal = MapProposal(uow.campus_id, uow.ids.new_id("proposal"), request_id, uow.now, by)
    _save(uow, proposal)
    record_event(uow, "map.proposal_asked", proposal.proposal_id, by, request.name)
    return proposal


def proposal_of(uow: UnitOfWork, proposal_id: str) -> MapProposal:
    """Raises ProposalUnknown."""
    proposal = uow.scans.proposal(proposal_id)
    if proposal is None:
        raise ProposalUnknown(f"there is no proposed map {proposal_id}; see GET /map-proposals")
    return proposal


def stop(uow: UnitOfWork, proposal_id: str, by: str) -> MapProposal:
    """Raises ProposalUnknown, ProposalNotReady."""
    proposal = proposal_of(uow, proposal_id)
    if not proposal.is_under_way:
        raise ProposalNotReady(f"it is not being made: it is {proposal.state}")
    stopped = replace(proposal, state="stopped", detail=f"stopped by {by}")
    _save(uow, stopped)
    record_event(uow, "map.proposal_stopped", proposal_id, by)
    return stopped


def take_next(uow: UnitOfWork) -> MapProposal | None:
    """The oldest one that waits, which the caller makes now. Those whose maker is silent have failed."""
    waiting = None
    for proposal in uow.scans.proposals_under_way():
        if proposal.is_silent_at(uow.now):
            _save(uow, failed(proposal, _SILENT))
            record_event(uow, "map.proposal_failed", proposal.proposal_id, THE_SERVER, _SILENT)
        elif proposal.state == "queued" and waiting is None:
            waiting = proposal
        elif proposal.state == "building":
            # One after another: it takes a core and much memory.
            return None
    if waiting is None:
        return None
    begun = replace(waiting, state="building", beat_at=uow.now)
    _save(uow, begun)
    return begun


def note_progress(uow: UnitOfWork, proposal_id: str, stage: str, percent: int) -> bool:
    """False: it is not to be made any more."""
    proposal = uow.scans.proposal(proposal_id)
    if proposal is None or proposal.state != "building":
        return False
    _save(uow, replace(proposal, stage=stage, percent=percent, beat_at=uow.now))
    return True


def note_result(uow: UnitOfWork, proposal_id: str, sha256: str, comparison: bytes) -> None:
    """The map is made; its files are in the store of scans. One that was stopped meanwhile stays so."""
    proposal = uow.scans.proposal(proposal_id)
    if proposal is None or proposal.state != "building":
        return
    ready = replace(
        proposal,
        state="ready",
        percent=100,
        result_sha256=sha256,
        comparison=comparison.decode(),
        beat_at=uow.now,
    )
    _save(uow, ready)
    record_event(uow, "map.proposed", proposal_id, THE_SERVER)


def note_failure(uow: UnitOfWork, proposal_id: str, detail: str) -> None:
    proposal = uow.scans.proposal(proposal_id)
    if proposal is None or proposal.state != "building":
        return
    _save(uow, failed(proposal, detail))
    record_event(uow, "map.proposal_failed", proposal_id, THE_SERVER, detail)


def publishable(uow: UnitOfWork, proposal_id: str) -> MapProposal:
    """A proposal that can be published now. Raises ProposalUnknown, ProposalNotReady, ProposalOutdated."""
    proposal = proposal_of(uow, proposal_id)
    if proposal.state != "ready":
        raise ProposalNotReady(f"it cannot be published: it is {proposal.state}")
    comparison = comparison_of(proposal)
    in_force = uow.localization_maps.in_force().get("points")
    present = "" if in_force is None else in_force.map_version
    # One that proposes what is in force already was put in force before its answer was lost.
    if comparison is not None and present not in (comparison.in_force_version, comparison.map_version):
        raise ProposalOutdated("another point map has been put in force since; make the proposal again")
    return proposal


def publish(uow: UnitOfWork, proposal_id: str, note: str, by: str) -> MapProposal:
    """Put the proposed map in force, whose tiles are stored by now.

    Raises ProposalUnknown, ProposalNotReady, ProposalOutdated, and what `localization_maps.activate` does.
    """
    proposal = publishable(uow, proposal_id)
    comparison = comparison_of(proposal)
    assert comparison is not None, "a ready proposal has one"
    localization_maps.activate(uow, comparison.map_version, by)
    return _decided(uow, replace(proposal, state="published"), note, by, "map.proposal_published")


def dismiss(uow: UnitOfWork, proposal_id: str, note: str, by: str) -> MapProposal:
    """Raises ProposalUnknown, ProposalNotReady."""
    proposal = proposal_of(uow, proposal_id)
    if proposal.state != "ready":
        raise ProposalNotReady(f"it cannot be dismissed: it is {proposal.state}")
    return _decided(uow, replace(proposal, state="dismissed"), note, by, "map.proposal_dismissed")


def comparison_of(proposal: MapProposal) -> Comparison | None:
    """Its figures; None before it is ready."""
    return msgspec.json.decode(proposal.comparison, type=Comparison) if proposal.comparison else None


def _decided(uow: UnitOfWork, proposal: MapProposal, note: str, by: str, event: str) -> MapProposal:
    decided = replace(proposal, decided_at=uow.now, decided_by=by, note=note)
    _save(uow, decided)
    record_event(uow, event, proposal.proposal_id, by, note)
    return decided


def _save(uow: UnitOfWork, proposal: MapProposal) -> None:
    uow.scans.save_proposal(proposal)
    uow.publish(topics.scans(uow.campus_id))
