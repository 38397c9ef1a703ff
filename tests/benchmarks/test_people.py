"""People of the model on recordings that others bring, and what the crowd benchmark tells of people."""

import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks.crowd import people_summary
from benchmarks.people.__main__ import drive_encounters
from benchmarks.people.distributions import Encounters, joined
from benchmarks.people.samples import Drive, drives_of, outline
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.reproduction import Reproduction, reproduction

ROOT = Path(__file__).resolve().parents[2]
SHARED = Path(os.environ.get("CAMPUSLOOP_SHARED", ROOT.parent / "shared"))
# Drives in which people slow down for the car.
CLIPS = ("intersection_08_traj", "intersection_12_traj", "roundabout_02_traj")
PARAMS = ReactionParams()


@pytest.fixture(scope="module")
def drives() -> list[Drive]:
    folder = SHARED / "data" / "crowds" / "dut"
    if not folder.is_dir():
        pytest.skip(f"no recordings under {folder}; set CAMPUSLOOP_SHARED")
    held_out = [drive for drive in drives_of(folder) if not drive.is_fitted]
    if not held_out:
        pytest.skip(f"{folder} has only recordings on which the model was fitted")
    return held_out


@pytest.fixture(scope="module")
def reproductions(drives: list[Drive]) -> list[Reproduction]:
    chosen = [drive for drive in drives if drive.clip.name in CLIPS] or drives[:3]
    return [reproduction(drive.clip, drive.car, outline(drive.car), PARAMS) for drive in chosen]


@pytest.fixture(scope="module")
def met(drives: list[Drive]) -> tuple[Encounters, Encounters, Encounters]:
    """As recorded; people who heed nothing, and people of the model, as the car comes at other times."""
    found = [drive_encounters(drive, PARAMS, (-1.0, 1.0)) for drive in drives]
    return (
        joined([recorded for recorded, _, _ in found]),
        joined([each for _, unheeding, _ in found for each in unheeding]),
        joined([each for _, _, aware in found for each in aware]),
    )


def test_people_walk_as_recorded_when_the_car_drives_as_it_did(reproductions: list[Reproduction]) -> None:
    assert float(np.concatenate([each.deployed_m for each in reproductions]).mean()) < 0.15
    assert float(np.concatenate([each.population_m for each in reproductions]).mean()) < 0.15


def test_the_cars_influence_is_recreated_on_people_who_were_not_fitted(
    reproductions: list[Reproduction],
) -> None:
    recreated = float(np.concatenate([each.recreated_m for each in reproductions]).mean())
    unheeding = float(np.concatenate([each.unheeding_m for each in reproductions]).mean())
    assert recreated < 0.9 * unheeding


def test_people_slow_down_no_earlier_than_recorded_people(
    met: tuple[Encounters, Encounters, Encounters],
) -> None:
    recorded, _, aware = met
    for quantile in (0.9, 0.95):
        assert np.quantile(aware.onsets_s, quantile) <= np.quantile(recorded.onsets_s, quantile)


def test_people_slow_down_no_harder_than_recorded_people(
    met: tuple[Encounters, Encounters, Encounters],
) -> None:
    recorded, _, aware = met
    for quantile in (0.9, 0.95):
        assert np.quantile(aware.decels_mps2, quantile) <= np.quantile(recorded.decels_mps2, quantile)


def test_people_leave_no_wider_gaps_than_recorded_people(
    met: tuple[Encounters, Encounters, Encounters],
) -> None:
    recorded, unheeding, aware = met
    assert np.median(aware.gaps_m) <= np.median(recorded.gaps_m) + 0.05
    assert (aware.gaps_m < 0.0).sum() < (unheeding.gaps_m < 0.0).sum()


def test_the_summary_counts_who_was_taken_out_of_the_scenes() -> None:
    rows = [{"people_removed": 2, "people_delayed": 0}, {"people_removed": 1, "people_delayed": 3}]
    assert people_summary(rows, []) == {"people.removed": 3, "people.delayed": 3}


def test_the_summary_has_the_mean_displacement_of_all_runs() -> None:
    none = np.zeros(0)
    runs = [
        Reproduction(np.array([0.1, 0.3]), none, none, none),
        Reproduction(np.array([0.2]), none, none, none),
    ]
    found = people_summary([], runs)
    assert found["people.displacement_m"] == pytest.approx(0.2)
    assert found["people.recreated_displacement_m"] is None
