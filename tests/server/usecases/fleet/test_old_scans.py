"""Which scans and proposed maps are old enough to be deleted, on each database."""

from dataclasses import replace
from datetime import datetime, timedelta

import pytest

from server.domain.fleet.scans import MapProposal, ProposalState, ScanParcel, ScanRequest
from server.usecases.fleet import old_scans
from tests.server.usecases.campus_under_test import CampusUnderTest

DAY = timedelta(days=1)


class Scans:
    """Requests of one parcel each, by name; the parcel's hash is the name."""

    def __init__(self, campus: CampusUnderTest) -> None:
        self.campus = campus
        self.began: datetime = campus.clock.now()
        self.campus_id = campus.road_map.campus_id

    def request(self, name: str, until: datetime, ended_at: datetime | None = None) -> None:
        request = ScanRequest(
            self.campus_id, name, name, (), 0.5, 1_000_000, until, self.began, "ann", ended_at=ended_at
        )
        parcel = ScanParcel(self.campus_id, name, name, "shuttle-1", "drive", 0, 2, 0.5, 100, self.began)
        self.campus.do(lambda uow: uow.scans.save_request(request))
        self.campus.do(lambda uow: uow.scans.add_parcel(parcel))

    def proposal(
        self, name: str, of: str, state: ProposalState, decided_at: datetime | None = None, sha256: str = ""
    ) -> None:
        proposal = MapProposal(self.campus_id, name, of, self.began, "ann", state)
        made = replace(proposal, decided_at=decided_at, result_sha256=sha256, comparison="{}", note="why")
        self.campus.do(lambda uow: uow.scans.save_proposal(made))

    def outdated_after(self, days: float) -> set[str]:
        self.campus.clock.advance(((self.began + days * DAY) - self.campus.clock.now()).total_seconds())
        return set(self.campus.read(old_scans.outdated))


@pytest.fixture
def scans(campus: CampusUnderTest) -> Scans:
    return Scans(campus)


def test_scans_go_ninety_days_after_their_request_is_over_and_not_after_they_came(scans: Scans) -> None:
    now = scans.began
    scans.request("ended", now + 30 * DAY, ended_at=now + DAY)
    scans.request("over", now + 20 * DAY)
    assert scans.outdated_after(91.0) == set()
    assert scans.outdated_after(91.1) == {"ended"}
    assert scans.outdated_after(110.1) == {"ended", "over"}


def test_scans_of_a_map_that_is_made_of_them_now_stay(scans: Scans) -> None:
    scans.request("library", scans.began + DAY)
    scans.proposal("one", "library", "building")
    assert scans.outdated_after(200.0) == set()
    scans.proposal("one", "library", "failed")
    assert scans.outdated_after(200.0) == {"library"}


def test_a_decided_proposal_loses_its_files_and_keeps_figures_and_decision(scans: Scans) -> None:
    now = scans.began
    scans.proposal("published", "gone", "published", now + DAY, "result-1")
    scans.proposal("dismissed", "gone", "dismissed", now + 5 * DAY, "result-2")
    scans.proposal("waiting", "gone", "ready", None, "result-3")
    assert scans.outdated_after(91.1) == {"result-1"}
    scans.campus.do(lambda uow: old_scans.forget(uow, "result-1"))
    kept = scans.campus.read(lambda uow: uow.scans.proposal("published"))
    assert kept is not None
    assert (kept.result_sha256, kept.comparison, kept.note, kept.state) == ("", "{}", "why", "published")
    assert scans.outdated_after(400.0) == {"result-2"}


def test_a_forgotten_parcel_is_forgotten_once(scans: Scans) -> None:
    scans.request("library", scans.began + DAY)
    assert scans.outdated_after(200.0) == {"library"}
    for _ in range(2):
        scans.campus.do(lambda uow: old_scans.forget(uow, "library"))
    assert scans.outdated_after(200.0) == set()
    assert scans.campus.read(lambda uow: uow.scans.request("library")) is not None
