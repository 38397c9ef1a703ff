"""The cells are what they say: unbraked, each ends in a contact at the front."""

import numpy as np
import pytest

from campusloop.scenes.contact_metrics import contact_metrics
from campusloop.scenes.protection.braking_oracle import best_braking
from campusloop.scenes.protection.cell import Cell
from campusloop.scenes.protection.cells import cells
from contract.geometry import arc_lengths, pose_at
from simulator.traffic.replayed import ReplayedTraffic
from vehicle_agent.config import Body

BODY = Body()
ALL = list(cells(BODY))


def unbraked(cell: Cell) -> bool:
    """Whether driving on at the cell's speed meets the target with the front."""
    s, traffic = arc_lengths(np.ascontiguousarray(cell.path)), ReplayedTraffic(cell.clip, 0.0)
    rows, agents = [], []
    for k in range(2200):
        t_s = 0.01 * k
        traffic.clock_s = t_s
        pose = pose_at(cell.path, s, cell.start_s_m + cell.speed_mps * t_s)
        rows.append((t_s, *pose, cell.speed_mps, 0.0, 0.0))
        agents.append(traffic.bodies())
    contacts = contact_metrics(np.array(rows), agents, BODY).front_contacts
    return any(number == 1 for _, number, _ in contacts)


def test_there_are_two_thousand_with_names_of_their_own() -> None:
    assert 2000 <= len(ALL) <= 2200
    assert len({cell.name for cell in ALL}) == len(ALL)


@pytest.mark.parametrize("cell", ALL[::37], ids=lambda cell: str(cell.name))
def test_unbraked_it_ends_in_a_contact_at_the_front(cell: Cell) -> None:
    assert unbraked(cell)


def test_an_occluded_child_is_seen_late_and_a_crossing_adult_at_once() -> None:
    child = next(cell for cell in ALL if cell.name == "day-child-5-1.0-0.50-15.0")
    adult = next(cell for cell in ALL if cell.name == "day-walks-far-0.50-15.0")
    late, early = (best_braking(cell, BODY, 3.2).seen_s for cell in (child, adult))
    assert late is not None
    assert late > 3.0
    assert early == 0.0


def test_at_night_less_is_seen() -> None:
    night = next(cell for cell in ALL if cell.name == "night-stands-0.50-20.0")
    seen_s = best_braking(night, BODY, 3.2).seen_s
    assert seen_s is not None
    assert seen_s > 0.5
