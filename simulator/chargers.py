"""Chargers at resting places: a shuttle at rest there is charged."""

import numpy as np

from contract.geometry import Array
from contract.roads.network import RoadNetwork

# A single-phase wall box.
CHARGER_W = 7.4e3
# The shuttle stops within decimetres of the place; the charger reaches this far.
REACH_M = 2.0


class Chargers:
    """places_map (k, 2): where the rear axle of a charged shuttle is."""

    def __init__(self, network: RoadNetwork) -> None:
        places = network.road_map.charging_places
        self.places_map: Array = np.array(
            [network.pose(place.lane_id, place.s_m)[:2] for place in places]
        ).reshape(len(places), 2)

    def power_w(self, places_map: Array, speeds_mps: Array) -> Array:
        """(n,) power into each vehicle's battery; places_map (n, 2), speeds_mps (n,)."""
        if not len(self.places_map):
            return np.zeros(len(places_map))
        away_m = np.linalg.norm(places_map[:, None, :] - self.places_map[None, :, :], axis=2).min(axis=1)
        power: Array = np.where((speeds_mps == 0.0) & (away_m <= REACH_M), CHARGER_W, 0.0)
        return power
