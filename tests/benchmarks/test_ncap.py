"""The jobs of `benchmarks.ncap`, and that they give the same figures on one worker and on two."""

import argparse
from pathlib import Path

import pytest

from benchmarks.ncap.__main__ import cell_drives, street_drives, summary
from benchmarks.ncap.drives import CellDrive, StreetResult, drive_cell
from campusloop.campaigns.choice import open_campaign

PROFILE = Path("vehicle_agent/profiles/snow-lion.toml")


def arguments(**changes: object) -> argparse.Namespace:
    values: dict[str, object] = {
        "profile": PROFILE, "every": 1, "seed": 1, "plants": "random", "plant_seed": None,
        "traces": None, "logs": None, "logs_of": "", "street_km": 1.0, "perception": "tracker",
    }  # fmt: skip
    return argparse.Namespace(**(values | changes))


def test_a_cell_has_the_same_vehicle_whichever_others_are_driven() -> None:
    every = {job.cell.name: job.plant_seed for job in cell_drives(arguments())}
    some = {job.cell.name: job.plant_seed for job in cell_drives(arguments(every=100))}
    assert len(set(every.values())) == len(every)
    assert some == {name: every[name] for name in some}
    other = {job.plant_seed for job in cell_drives(arguments(seed=2))}
    assert not other & set(every.values())


def test_plants_can_be_nominal_or_one_for_all() -> None:
    assert {job.plant_seed for job in cell_drives(arguments(plants="nominal"))} == {None}
    assert {job.plant_seed for job in cell_drives(arguments(plant_seed=7))} == {7}
    streets = list(street_drives(arguments()))
    assert [street.seed for street in streets] == [1, 2]
    assert len({street.plant_seed for street in streets}) == 2


def test_needless_stops_and_contacts_are_counted() -> None:
    rows = [
        {"avoidable": True, "avoided": True, "impact_mps": None, "least_impact_mps": None, "passed": True},
        {"avoidable": True, "avoided": False, "impact_mps": 1.0, "least_impact_mps": None, "passed": True},
        {"avoidable": False, "avoided": False, "impact_mps": 3.0, "least_impact_mps": 2.0, "passed": False},
    ]
    found = summary(rows, [StreetResult(1, 500.0, 125.0), StreetResult(2, 500.0, 125.0)])
    assert found["avoidable_avoided_pct"] == 50.0
    assert found["unavoidable_worse_than_10_pct"] == 1
    assert found["false_stops"] == 3
    assert found["street_mean_kmh"] == pytest.approx(14.4)


@pytest.mark.long
def test_two_workers_give_the_same_rows_as_one() -> None:
    jobs: list[CellDrive] = list(cell_drives(arguments(every=700)))
    assert 2 <= len(jobs) <= 4
    rows = []
    for workers in (1, 2):
        with open_campaign(None, workers) as campaign:
            rows.append(list(campaign.run(drive_cell, jobs)))
    assert rows[0] == rows[1]
