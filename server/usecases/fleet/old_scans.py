"""Scans and proposed maps are forgotten `scan_days` after they were needed: people may be seen in scans."""

from dataclasses import replace
from datetime import timedelta

from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork

FORGOTTEN_AT_A_TIME = 200


def outdated(uow: UnitOfWork) -> tuple[str, ...]:
    """Hashes of parcels whose request ended long ago, and of proposals that were decided long ago.

    Some at a time. Parcels of a map that is being made stay, as does a proposal that waits for a decision.
    """
    before = uow.now - timedelta(days=uow.rules.scan_days)
    in_use = frozenset(one.request_id for one in uow.scans.proposals_under_way())
    parcels = uow.scans.parcels_ended_before(before, in_use, FORGOTTEN_AT_A_TIME)
    results = uow.scans.results_decided_before(before, FORGOTTEN_AT_A_TIME)
    return (*(one.sha256 for one in parcels), *(one.result_sha256 for one in results))


def forget(uow: UnitOfWork, sha256: str) -> None:
    """Its bytes are deleted. Of a proposal, the figures and the decision stay."""
    uow.scans.remove_parcel(sha256)
    for proposal in uow.scans.proposals_of_result(sha256):
        uow.scans.save_proposal(replace(proposal, result_sha256=""))
    uow.publish(topics.scans(uow.campus_id))
