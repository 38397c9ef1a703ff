"""Localization maps and the scans that they are made of, as rows of each database."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from contract.roads.model import Origin
from server.domain.errors import (
    LocalizationMapElsewhere,
    LocalizationMapIncomplete,
    LocalizationMapInForce,
    LocalizationMapUnknown,
    LocalizationTileUnknown,
)
from server.domain.fleet.scans import ScanContribution
from server.domain.roads.localization_maps import LocalizationMap
from server.usecases.fleet import localization_maps as maps
from server.usecases.fleet import scans
from tests.contract.localization_folders import occupancy_map, point_map
from tests.server.usecases.campus_under_test import CampusUnderTest


class Campus:
    """Maps are made in a folder of the test and stored from there."""

    def __init__(self, campus: CampusUnderTest, folder: Path) -> None:
        self.campus, self.folder, self.count = campus, folder, 0

    def store(self, changed: int = 0, kind: str = "points", moved_deg: float = 0.0) -> LocalizationMap:
        self.count += 1
        folder, origin = self.folder / str(self.count), self.campus.road_map.origin
        origin = Origin(origin.latitude_deg + moved_deg, origin.longitude_deg)
        if kind == "points":
            point_map(folder, origin, changed=changed)
        else:
            occupancy_map(folder, origin)
        data = (folder / "index.json").read_bytes()
        manifest = maps.decoded(data)
        return self.campus.do(lambda uow: maps.store_manifest(uow, data, manifest, "ann", "first"))

    def missing(self, stored: LocalizationMap) -> frozenset[str]:
        return frozenset(self.campus.read(lambda uow: maps.missing_tiles(uow, stored.map_version)))

    def keep(self, stored: LocalizationMap) -> None:
        tiles = self.missing(stored)
        self.campus.do(lambda uow: maps.keep_tiles(uow, stored.map_version, tiles))

    def activate(self, stored: LocalizationMap) -> LocalizationMap:
        return self.campus.do(lambda uow: maps.activate(uow, stored.map_version, "ann"))

    def in_force(self) -> dict[str, str]:
        found = self.campus.read(lambda uow: uow.localization_maps.in_force())
        return {kind: one.map_version for kind, one in found.items()}


@pytest.fixture
def lab(campus: CampusUnderTest, tmp_path: Path) -> Campus:
    return Campus(campus, tmp_path)


def test_a_map_is_stored_filled_and_put_in_force_beside_the_one_of_the_other_kind(lab: Campus) -> None:
    points, grid = lab.store(), lab.store(kind="occupancy")
    with pytest.raises(LocalizationMapIncomplete):
        lab.activate(points)
    for one in (points, grid):
        lab.keep(one)
        assert not lab.missing(one)
        lab.activate(one)
    assert lab.in_force() == {"points": points.map_version, "occupancy": grid.map_version}
    stored = lab.campus.read(lambda uow: maps.localization_map_of(uow, points.map_version))
    assert (stored.active, stored.activated_by, stored.note) == (True, "ann", "first")
    assert stored.origin == points.origin
    assert lab.store() == stored, "a repeat gives the stored one"


def test_a_newer_version_takes_over_and_shares_the_tiles_that_it_did_not_change(lab: Campus) -> None:
    older = lab.store()
    lab.keep(older)
    lab.activate(older)
    newer = lab.store(changed=1)
    assert len(lab.missing(newer)) < newer.tile_count
    lab.keep(newer)
    lab.activate(newer)
    assert lab.in_force() == {"points": newer.map_version}
    with pytest.raises(LocalizationMapInForce):
        lab.campus.do(lambda uow: maps.remove(uow, newer.map_version, "ann"))
    gone = lab.campus.do(lambda uow: maps.remove(uow, older.map_version, "ann"))
    assert len(gone) == 1, "the tile that the newer one has changed"
    assert not lab.missing(newer)
    with pytest.raises(LocalizationMapUnknown):
        lab.campus.read(lambda uow: maps.localization_map_of(uow, older.map_version))


def test_what_does_not_belong_is_refused(lab: Campus) -> None:
    stored = lab.store()
    with pytest.raises(LocalizationTileUnknown):
        lab.campus.do(lambda uow: maps.keep_tiles(uow, stored.map_version, frozenset({64 * "0"})))
    with pytest.raises(LocalizationMapElsewhere, match="in force at"):
        lab.store(changed=1, moved_deg=0.1)
    with pytest.raises(LocalizationMapElsewhere, match="in force at"):
        lab.store(moved_deg=0.1)


def test_tiles_that_are_stored_with_a_wrong_origin_are_not_taken_for_those_of_another_place(
    lab: Campus,
) -> None:
    """The campus's road map had another origin when they came."""
    stored = lab.store()
    wrong = replace(stored, origin=Origin(stored.origin.latitude_deg + 0.1, stored.origin.longitude_deg))
    lab.campus.do(lambda uow: uow.localization_maps.save(wrong))
    with pytest.raises(LocalizationMapElsewhere, match="remove that version first"):
        lab.store()
    lab.campus.do(lambda uow: maps.remove(uow, stored.map_version, "ann"))
    assert lab.store().origin == stored.origin


def test_requests_and_contributions_come_newest_first_and_page_by_page(lab: Campus) -> None:
    campus = lab.campus
    for name in ("area 0", "area 1", "area 2", "area 3", "area 4"):
        ask = partial(
            scans.request_scans, name=name, outline=(), every_m=0.5, bytes_max=100, hours=1.0, by="ann"
        )
        request_id = campus.do(ask).request_id
        campus.do(partial(scans.end_request, request_id=request_id, by="ann"))
        campus.clock.advance(1.0)
    first = campus.read(lambda uow: uow.scans.newest_requests(3))
    assert [one.name for one in first] == ["area 4", "area 3", "area 2"]
    rest = campus.read(lambda uow: uow.scans.newest_requests(3, (first[-1].started_at, first[-1].request_id)))
    assert [one.name for one in rest] == ["area 1", "area 0"]
    said = ScanContribution(
        first[0].request_id, "shuttle-1", "collecting", "", 3, 1.5, 900, campus.clock.now()
    )
    campus.do(lambda uow: uow.scans.save_contribution(said))
    campus.do(lambda uow: uow.scans.save_contribution(replace(said, scans=7)))
    (kept,) = campus.read(lambda uow: uow.scans.contributions(first[0].request_id))
    assert kept.scans == 7
