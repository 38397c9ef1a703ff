"""The vehicles' start poses in a world."""

from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from simulator.world import WorldError


def start_poses(road_map: RoadMap, vehicle_ids: tuple[str, ...]) -> dict[str, Pose2]:
    """One resting place of the map for each vehicle, in map order.

    WorldError when the map has fewer resting places than there are vehicles.
    """
    places = road_map.resting_places
    if len(vehicle_ids) > len(places):
        raise WorldError(
            f"{road_map.name} has {len(places)} resting places, too few for {len(vehicle_ids)} vehicles"
        )
    network = RoadNetwork(road_map)
    return {
        vehicle_id: Pose2(*network.pose(place.lane_id, place.s_m))
        for vehicle_id, place in zip(vehicle_ids, places, strict=False)
    }
