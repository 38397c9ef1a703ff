"""The campus map as the onboard screen draws it, in the form of the server's `MapGeometry`."""

from typing import Any

import msgspec

from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork


def encode_screen_map(road_map: RoadMap) -> bytes:
    """JSON: map_version, attribution, timezone, lanes, buildings, stops and areas; lengths in metres."""
    network = RoadNetwork(road_map)
    return msgspec.json.encode(
        {
            "map_version": road_map.map_version,
            "attribution": road_map.attribution,
            "timezone": road_map.timezone,
            "lanes": [
                {
                    "lane_id": lane.lane_id,
                    "kind": lane.kind,
                    "name": lane.name,
                    "name_en": lane.name_en,
                    "xy": _flat(lane.points),
                    "width_m": lane.width_m,
                }
                for lane in road_map.lanes
            ],
            "buildings": [{"xy": _flat(building.outline)} for building in road_map.buildings],
            "stops": [_stop(network, stop_id) for stop_id in sorted(network.stops)],
            "areas": [
                {"area_id": area.area_id, "xy": _flat(area.outline)} for area in road_map.observation_areas
            ],
        }
    )


def _stop(network: RoadNetwork, stop_id: str) -> dict[str, Any]:
    stop = network.stops[stop_id]
    x_m, y_m, _ = network.pose(stop.lane_id, stop.s_m)
    return msgspec.structs.asdict(stop) | {"x_m": round(float(x_m), 2), "y_m": round(float(y_m), 2)}


def _flat(points: tuple[tuple[float, float], ...]) -> list[float]:
    return [round(float(value), 2) for point in points for value in point]
