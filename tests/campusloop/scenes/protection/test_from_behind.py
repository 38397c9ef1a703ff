"""Riders who overtake and get in the way, and cars that reverse."""

import math

import numpy as np
import pytest

from campusloop.scenes.protection.braking_oracle import best_braking
from campusloop.scenes.protection.cell import Cell
from campusloop.scenes.protection.cells import cells
from simulator.traffic.replayed import ReplayedTraffic
from vehicle_agent.config import Body

BODY = Body()
CELLS = {cell.name: cell for cell in cells(BODY)}


def place(cell: Cell, t_s: float) -> tuple[float, float, float]:
    """The target's x and y, and the unbraked vehicle's bumper."""
    traffic = ReplayedTraffic(cell.clip, 0.0)
    traffic.clock_s = t_s
    pose = traffic.bodies().poses_map[0]
    return float(pose[0]), float(pose[1]), cell.start_s_m + cell.speed_mps * t_s + BODY.front_overhang_m


def test_a_rider_comes_from_behind_and_turns_in_just_ahead_of_the_bumper() -> None:
    cell = CELLS["day-behind-scooter-fast-slows-left-0.50-15.0"]
    x_m, y_m, bumper_m = place(cell, 0.0)
    assert x_m < bumper_m
    assert y_m > 0.5 * BODY.width_m + 1.0
    x_m, y_m, bumper_m = place(cell, cell.harmless_s)
    assert 1.0 < x_m - 0.6 - bumper_m < 2.0
    assert y_m > 0.5 * BODY.width_m + 0.9
    _, y_m, _ = place(cell, cell.harmless_s + 1.0)
    assert y_m == pytest.approx(0.0, abs=0.05)


def test_nobody_brakes_before_a_rider_shows_the_turn() -> None:
    cell = CELLS["day-behind-cyclist-stops-right-0.50-20.0"]
    assert cell.harmless_s > 1.0
    assert best_braking(cell, BODY, 3.2).seen_s == pytest.approx(cell.harmless_s, abs=0.011)


def test_a_car_reverses_out_of_a_bay_and_a_van_hides_it() -> None:
    open_bay = CELLS["day-reverses-bay-3-near-0.50-15.0"]
    hidden = CELLS["day-reverses-bay-beside-van-3-near-0.50-15.0"]
    moving = open_bay.clip.tracks[0].states[2]
    assert math.cos(moving[2]) * moving[3] + math.sin(moving[2]) * moving[4] == pytest.approx(-3.0 / 3.6)
    early, late = (best_braking(cell, BODY, 3.2).seen_s for cell in (open_bay, hidden))
    assert early is not None
    assert late is not None
    assert early == pytest.approx(open_bay.harmless_s, abs=0.011)
    assert early > 1.0
    # The same place at the contact, but a metre more to come.
    assert late > hidden.harmless_s + 0.5


def test_tracks_are_finite_and_in_order() -> None:
    for cell in list(CELLS.values())[::29]:
        for track in cell.clip.tracks:
            assert np.isfinite(track.states).all()
            assert (np.diff(track.times_s) > 0.0).all()
