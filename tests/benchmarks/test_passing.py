"""How near people pass before a vehicle that stands: a made recording, and the reactive crowd."""

import numpy as np
import pytest

from benchmarks.people.__main__ import passes_row
from benchmarks.people.passing import crowd_passes_m, recorded_passes_m
from simulator.traffic.recordings import Clip, RecordedTrack
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

TIMES_S = np.arange(0.0, 6.0, 0.1)


def track(number: int, kind: int, start: tuple[float, float], mps: tuple[float, float]) -> RecordedTrack:
    n = len(TIMES_S)
    states = np.zeros((n, 5))
    states[:, :2] = np.array(start) + TIMES_S[:, None] * np.array(mps)
    states[:, 3:5] = mps
    return RecordedTrack(number, kind, TIMES_S, states, (4.5, 1.8) if kind == VEHICLE else (0.5, 0.5))


def clip(car_mps: float, *people: RecordedTrack) -> Clip:
    return Clip("made", (track(100_000, VEHICLE, (0.0, 0.0), (car_mps, 0.0)), *people), 6.0)


def test_a_pass_is_measured_from_the_bumper_to_the_middle_of_the_person() -> None:
    crosses = track(1, PEDESTRIAN, (4.0, 3.0), (0.0, -1.2))
    assert recorded_passes_m([clip(0.0, crosses)]) == pytest.approx([4.0 - 2.25])


def test_who_is_beside_behind_or_along_does_not_pass_and_nobody_passes_a_car_that_drives() -> None:
    beside = track(1, PEDESTRIAN, (0.0, 3.0), (0.0, -0.5))
    behind = track(2, PEDESTRIAN, (-4.0, 3.0), (0.0, -1.2))
    along = track(3, PEDESTRIAN, (6.0, 0.2), (-0.5, 0.0))
    crosses = track(4, PEDESTRIAN, (9.0, 3.0), (0.0, -1.2))
    assert len(recorded_passes_m([clip(0.0, beside, behind, along)])) == 0
    assert len(recorded_passes_m([clip(0.5, crosses)])) == 0


def test_attentive_people_leave_a_standing_shuttle_as_much_room_as_recorded_people() -> None:
    passes = crowd_passes_m((21, 22))
    assert len(passes) > 20
    # Recorded people: 7 and 3 % of the two parts within a metre.
    assert passes_row(passes)["passes_within_1m_pct"] < 12.0


def test_no_passes_have_no_quantiles() -> None:
    assert passes_row(np.zeros(0)) == {
        "passes": 0,
        "passes_m_p5": None,
        "passes_m_p25": None,
        "passes_m_p50": None,
        "passes_within_1m_pct": None,
    }
