"""A job makes a proposal of scans; an operator looks at it and publishes or dismisses it."""

import io
import zipfile
from collections.abc import Callable, Iterator
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from server.domain.record.identity import Role
from server.usecases.fleet import map_proposals
from server.usecases.ports.scans import MapBuildRefused
from tests.server.api.scans.scanning import (
    PNG,
    PreparedBuilder,
    a_server,
    put_parcel,
    scan_map_loop,
    write_parcel,
)
from tests.server.api.security.test_roles import headers_of
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair


class Campus:
    """A server with scans of the whole campus by shuttle-1."""

    def __init__(self, server: ServerUnderTest, folder: Path) -> None:
        self.server = server
        server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
        self.headers = server.sign_in()
        asked = server.post("/scan-requests", {"name": "Library"}, headers=self.headers)
        self.request_id = str(asked.json()["request_id"])
        self.folder = folder

    def scan(self, number: int = 0) -> None:
        parcel = write_parcel(self.folder / f"{number}.zip", self.request_id, number=number)
        assert put_parcel(self.server, parcel.read_bytes()).status_code == 201

    def ask(self) -> Any:
        return self.server.post(f"/scan-requests/{self.request_id}/maps", headers=self.headers)

    def make(self, builder: PreparedBuilder | None = None) -> dict[str, Any]:
        """What comes of one that is asked for now."""
        proposal_id = self.ask().json()["proposal_id"]
        self.server.run(scan_map_loop(self.server, builder or PreparedBuilder()).run_once())
        return self.proposal(proposal_id)

    def proposal(self, proposal_id: str) -> dict[str, Any]:
        return dict(self.server.get(f"/map-proposals/{proposal_id}").json())

    def decide(
        self, proposal_id: str, what: str, note: str = "", headers: dict[str, str] | None = None
    ) -> Any:
        path = f"/map-proposals/{proposal_id}/{what}"
        return self.server.post(path, {"note": note}, headers=headers or self.headers)

    def in_force(self) -> str:
        found = [one for one in self.server.get("/localization-maps").json() if one["active"]]
        return str(found[0]["map_version"]) if found else ""


@pytest.fixture
def campus(tmp_path: Path) -> Iterator[Campus]:
    with a_server(tmp_path / "var") as server:
        campus = Campus(server, tmp_path)
        campus.scan()
        yield campus


def test_without_scans_no_map_is_asked_for(tmp_path: Path) -> None:
    with a_server(tmp_path / "var") as server:
        answer = Campus(server, tmp_path).ask()
        assert (answer.status_code, answer.json()["code"]) == (409, "no_scans_yet")


def test_a_proposal_has_figures_a_picture_and_a_map_and_is_not_in_force(campus: Campus) -> None:
    campus.scan(1)
    builder = PreparedBuilder()
    found = campus.make(builder)
    assert (found["state"], found["request_name"]) == ("ready", "Library")
    assert len(builder.parcels) == 2
    figures = found["comparison"]
    assert (figures["changed_ratio"], figures["tiles_changed"], figures["tiles_compared"]) == (0.0848, 1, 2)
    assert [(tile["ix"], tile["iy"], tile["moved"]) for tile in figures["tiles"]] == [(1, 0, 150)]
    assert figures["notes"] == ["Drive scans-7-2 was left out: it has one scan."]
    picture = campus.server.get(f"/map-proposals/{found['proposal_id']}/picture")
    assert (picture.headers["Content-Type"], picture.content) == ("image/png", PNG)
    file = campus.server.get(f"/map-proposals/{found['proposal_id']}/map")
    names = zipfile.ZipFile(io.BytesIO(file.content)).namelist()
    assert {"index.json", "comparison.json", "comparison.png", "tiles/0_0.tile"} <= set(names)
    assert campus.in_force() == ""
    assert [one["proposal_id"] for one in campus.server.get("/map-proposals").json()] == [
        found["proposal_id"]
    ]


def test_a_published_proposal_is_in_force_and_the_next_one_is_compared_with_it(campus: Campus) -> None:
    first = campus.make()
    published = campus.decide(first["proposal_id"], "publication", "The new wall is right.")
    assert (published.status_code, published.json()["state"]) == (200, "published")
    assert (published.json()["decided_by"], published.json()["note"]) == (
        "operator",
        "The new wall is right.",
    )
    assert campus.in_force() == first["comparison"]["map_version"]
    builder = PreparedBuilder(2)
    second = campus.make(builder)
    assert builder.in_force == first["comparison"]["map_version"]
    assert second["comparison"]["in_force_version"] == builder.in_force
    again = campus.decide(first["proposal_id"], "publication")
    assert (again.status_code, again.json()["code"]) == (409, "proposal_not_ready")
    said = campus.server.transact(lambda uow: [one.action.action for one in uow.audit.newest(10)])
    assert "publish_map_proposal" in said


def test_a_dismissed_proposal_changes_nothing_and_keeps_the_note(campus: Campus) -> None:
    found = campus.make()
    dismissed = campus.decide(found["proposal_id"], "dismissal", "A lorry stood there.")
    assert (dismissed.status_code, dismissed.json()["state"]) == (200, "dismissed")
    assert campus.proposal(found["proposal_id"])["note"] == "A lorry stood there."
    assert campus.in_force() == ""
    again = campus.decide(found["proposal_id"], "publication")
    assert (again.status_code, again.json()["code"]) == (409, "proposal_not_ready")


def test_a_proposal_compared_with_another_map_than_the_one_in_force_is_not_published(campus: Campus) -> None:
    older = campus.make()
    newer = campus.make(PreparedBuilder(2))
    assert campus.decide(newer["proposal_id"], "publication").status_code == 200
    answer = campus.decide(older["proposal_id"], "publication")
    assert (answer.status_code, answer.json()["code"]) == (409, "proposal_outdated")
    assert campus.in_force() == newer["comparison"]["map_version"]


def test_a_lost_answer_to_a_publication_is_repeated_with_the_same_key(campus: Campus) -> None:
    found = campus.make()
    headers = campus.headers | {"Idempotency-Key": "publication-1"}
    first = campus.decide(found["proposal_id"], "publication", headers=headers)
    again = campus.decide(found["proposal_id"], "publication", headers=headers)
    assert (first.status_code, again.status_code) == (200, 200)
    assert first.json() == again.json()


def test_scans_that_make_no_map_fail_with_the_reason(campus: Campus) -> None:
    class Refusing(PreparedBuilder):
        async def build(
            self, parcels: Path, in_force: Path | None, out: Path, tell: Callable[[str, int], None]
        ) -> None:
            raise MapBuildRefused("No drive makes a map: it has no usable fix.")

    found = campus.make(Refusing())
    assert (found["state"], found["detail"]) == ("failed", "No drive makes a map: it has no usable fix.")
    answer = campus.server.get(f"/map-proposals/{found['proposal_id']}/picture")
    assert (answer.status_code, answer.json()["code"]) == (409, "proposal_not_ready")
    # The scans are still there: it can be made again.
    assert campus.make()["state"] == "ready"


def test_one_map_at_a_time_is_made_of_a_requests_scans(campus: Campus) -> None:
    campus.ask()
    answer = campus.ask()
    assert (answer.status_code, answer.json()["code"]) == (409, "proposal_under_way")


def test_one_that_waits_can_be_stopped_and_is_not_made(campus: Campus) -> None:
    waiting = campus.ask().json()["proposal_id"]
    stopped = campus.decide(waiting, "dismissal")
    assert (stopped.status_code, stopped.json()["code"]) == (409, "proposal_not_ready")
    answer = campus.server.post(f"/map-proposals/{waiting}/stop", headers=campus.headers)
    assert (answer.status_code, answer.json()["state"]) == (200, "stopped")
    builder = PreparedBuilder()
    campus.server.run(scan_map_loop(campus.server, builder).run_once())
    assert builder.parcels == []


def test_what_is_stopped_while_it_is_made_stays_stopped(campus: Campus) -> None:
    proposal_id = campus.ask().json()["proposal_id"]
    campus.server.transact(map_proposals.take_next)
    campus.server.post(f"/map-proposals/{proposal_id}/stop", headers=campus.headers)
    campus.server.transact(lambda uow: map_proposals.note_result(uow, proposal_id, 64 * "a", b"{}"))
    assert not campus.server.transact(lambda uow: map_proposals.note_progress(uow, proposal_id, "x", 1))
    assert campus.proposal(proposal_id)["state"] == "stopped"


def test_one_whose_server_has_ended_has_failed_after_a_minute(campus: Campus) -> None:
    proposal_id = campus.ask().json()["proposal_id"]
    campus.server.transact(map_proposals.take_next)
    loop = scan_map_loop(campus.server, PreparedBuilder())
    campus.server.run(loop.run_once())
    assert campus.proposal(proposal_id)["state"] == "building"
    campus.server.elapse(timedelta(seconds=61).total_seconds())
    campus.server.run(loop.run_once())
    found = campus.proposal(proposal_id)
    assert (found["state"], found["detail"]) == (
        "failed", "the server that made it has ended; make it again"
    )  # fmt: skip


def test_a_map_in_force_whose_tile_is_lost_fails_with_the_reason(campus: Campus) -> None:
    campus.decide(campus.make()["proposal_id"], "publication")
    for path in (campus.server.settings.var_dir / "localization-tiles").rglob("*.tile"):
        path.unlink()
    found = campus.make()
    assert found["state"] == "failed"
    assert "of the map in force is not kept" in found["detail"]


@pytest.mark.parametrize(("role", "may"), [("dispatcher", False), ("safety", True)])
def test_who_may_publish(campus: Campus, role: Role, may: bool) -> None:
    found = campus.make()
    headers = headers_of(campus.server, frozenset({role}))
    answer = campus.decide(found["proposal_id"], "publication", headers=headers)
    assert (answer.status_code == 200) is may
    assert (campus.in_force() != "") is may


def test_unknown_ones_are_not_found(campus: Campus) -> None:
    for path in ("/map-proposals/none", "/map-proposals/none/picture", "/map-proposals/none/map"):
        answer = campus.server.get(path)
        assert (answer.status_code, answer.json()["code"]) == (404, "proposal_unknown")
    answer = campus.server.post("/scan-requests/none/maps", headers=campus.headers)
    assert (answer.status_code, answer.json()["code"]) == (404, "scan_request_unknown")
