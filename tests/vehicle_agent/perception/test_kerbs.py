"""Kerbs over several scans, in the map."""

import math

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.perception.kerbs import KerbMemory, KerbsState

MEMORY = KerbMemory()
SCAN_NS = 100_000_000


def seen(scans: int, state: KerbsState | None = None, begin_ns: int = SCAN_NS) -> KerbsState:
    """A kerb 3 m to the right of a vehicle that drives north at x = -50, 3 m/s."""
    state = state or KerbsState()
    for k in range(scans):
        pose = Pose2(-50.0, -20.0 + 0.3 * k, 0.5 * math.pi)
        along = np.arange(-24.0, -12.0, 0.25) + 0.1 - pose.y_m
        kerb = np.column_stack((along, np.full(len(along), -3.1)))
        state = MEMORY.step(state, kerb, pose, begin_ns + k * SCAN_NS)
    return state


def test_what_a_few_scans_have_shown_is_a_kerb() -> None:
    assert len(MEMORY.places_map(seen(2))) == 0
    places = MEMORY.places_map(seen(6))
    assert len(places) > 10
    assert np.abs(places[:, 0] - -46.9).max() < 0.13, "half a cell"
    assert places[:, 1].min() < -23.0
    assert places[:, 1].max() > -13.0


def test_what_is_not_seen_for_long_is_forgotten() -> None:
    state = seen(6)
    nothing = np.empty((0, 2))
    soon = MEMORY.step(state, nothing, Pose2(0.0, 0.0, 0.0), 3_000_000_000)
    assert len(MEMORY.places_map(soon)) == len(MEMORY.places_map(state))
    later = MEMORY.step(soon, nothing, Pose2(0.0, 0.0, 0.0), 7_000_000_000)
    assert len(MEMORY.places_map(later)) == 0
    assert len(later.cells) == 0


def test_cells_on_both_sides_of_the_origin_keep_their_places() -> None:
    state = KerbsState()
    places = np.array([(x, y) for x in (-0.1, 0.1, -31.4, 31.4) for y in (-0.1, 0.1, -17.9, 17.9)])
    for k in range(3):
        state = MEMORY.step(state, places, Pose2(0.0, 0.0, 0.0), (k + 1) * SCAN_NS)
    found = MEMORY.places_map(state)
    assert len(found) == len(places)
    for place in places:
        assert np.abs(found - place).max(axis=1).min() <= 0.125
