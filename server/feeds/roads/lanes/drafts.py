"""Lanes while they are being made, and what the making had to do."""

from dataclasses import dataclass, field

import numpy as np

from contract.geometry import Array, arc_lengths
from contract.roads.model import Lane, LaneKind, Scenario

_DECIMALS = 4


@dataclass(slots=True)
class LaneDraft:
    """A lane in the making: points (n, 2) in the map frame."""

    lane_id: str
    kind: LaneKind
    points: Array
    width_m: float
    speed_limit_mps: float
    can_pass: bool = False
    successors: list[str] = field(default_factory=list)
    scenario: Scenario = "common_road"
    name: str = ""
    name_en: str = ""

    def __post_init__(self) -> None:
        # Rounded before sections and stops are measured, so that they fit the lane as it is written.
        self.points = np.round(self.points, _DECIMALS) + 0.0

    @property
    def length_m(self) -> float:
        return float(arc_lengths(self.points)[-1])


@dataclass(slots=True)
class ImportLog:
    """What was repaired and what was left out, in the order in which it happened."""

    repairs: list[str] = field(default_factory=list)
    dropped: list[str] = field(default_factory=list)


def finished_lane(draft: LaneDraft) -> Lane:
    """The immutable lane."""
    return Lane(
        lane_id=draft.lane_id,
        kind=draft.kind,
        points=tuple((float(x), float(y)) for x, y in draft.points),
        width_m=draft.width_m,
        speed_limit_mps=draft.speed_limit_mps,
        can_pass=draft.can_pass,
        successors=tuple(draft.successors),
        scenario=draft.scenario,
        name=draft.name,
        name_en=draft.name_en,
    )
