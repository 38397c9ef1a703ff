"""Places of the active map where riders board and alight."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CampusStop:
    """A stop with its place on the road and its position in the map frame and on the globe."""

    stop_id: str
    name: str
    name_en: str
    lane_id: str
    s_m: float
    x_m: float
    y_m: float
    placed_by: str
