"""Driving rules by the map's scenario tags (Snow Lion, behavioral planning)."""

import msgspec

from contract.roads.model import SCENARIOS


class ScenarioRules(msgspec.Struct, frozen=True):
    """The rules of one scenario tag.

    offsets_m       lateral offsets of the reference route to choose from, left positive, 0 among them
    inflation_m     w_o: road users' outlines are widened by this
    speed_mps_max   v_r: the reference speed
    """

    offsets_m: tuple[float, ...]
    inflation_m: float
    speed_mps_max: float


COMMON_ROAD = ScenarioRules((-1.2, -0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9, 1.2), 0.12, 12.0)
# A parked car may pull out at any moment: slower, wider, and no weaving.
PARKING_LOT = ScenarioRules((-0.6, -0.3, 0.0, 0.3, 0.6), 0.25, 2.8)
# In a junction other road users rely on the lane: keep to it.
UNPROTECTED_INTERSECTION = ScenarioRules((-0.3, 0.0, 0.3), 0.18, 3.4)

SCENARIO_RULES: tuple[ScenarioRules, ...] = (COMMON_ROAD, PARKING_LOT, UNPROTECTED_INTERSECTION)
assert len(SCENARIO_RULES) == len(SCENARIOS)
