"""Maps with everything that can be drawn, and how far one map lies from another."""

import math

from msgspec.structs import replace

from contract.roads.load import with_version
from contract.roads.model import Kerb, NoStoppingZone, RoadMap, RoadSign
from contract.roads.network import RoadNetwork


def with_drawn(road_map: RoadMap, zone: tuple[float, float], kerb_name: str) -> RoadMap:
    """The map with a no-stopping zone and a sign on the first lane without stops, and a kerb far from all."""
    used = {stop.lane_id for stop in road_map.stops} | {place.lane_id for place in road_map.resting_places}
    network = RoadNetwork(road_map)
    lane = next(lane for lane in road_map.lanes if lane.lane_id not in used and lane.kind == "road")
    length_m = network.lines[lane.lane_id].length_m
    begin, end = sorted(share * length_m for share in zone)
    zones = (NoStoppingZone("zone-1", lane.lane_id, begin, end),) if begin < end else ()
    kerbs = (Kerb(kerb_name, ((2000.0, 2000.0), (2010.5, 2003.25), (2020.0, 1999.0))),)
    signs = (RoadSign("sign-1", "yield", lane.lane_id, round(0.5 * length_m, 3), "left"),)
    return with_version(replace(road_map, no_stopping_zones=zones, kerbs=kerbs, signs=signs))


def farthest_m(one: RoadMap, other: RoadMap) -> float:
    """The farthest that two points, stops, outlines or ends of zones of the same name lie apart."""
    here, there = places_of(one), places_of(other)
    assert here.keys() == there.keys()
    return max(math.dist(a, b) for name in here for a, b in zip(here[name], there[name], strict=True))


def places_of(road_map: RoadMap) -> dict[str, list[tuple[float, float]]]:
    network = RoadNetwork(road_map)

    def at(lane_id: str, s_m: float) -> tuple[float, float]:
        x_m, y_m, _ = network.pose(lane_id, s_m)
        return x_m, y_m

    places = {f"lane {lane.lane_id}": list(lane.points) for lane in road_map.lanes}
    places |= {f"stop {stop.stop_id}": [at(stop.lane_id, stop.s_m)] for stop in road_map.stops}
    places |= {f"rest {one.place_id}": [at(one.lane_id, one.s_m)] for one in road_map.resting_places}
    places |= {f"area {area.area_id}": list(area.outline) for area in road_map.observation_areas}
    places |= {
        f"line {area.area_id}": [at(*line) for line in area.stop_lines] for area in road_map.observation_areas
    }
    places |= {
        f"zone {zone.zone_id}": [at(zone.lane_id, zone.s_from_m), at(zone.lane_id, zone.s_to_m)]
        for zone in road_map.no_stopping_zones
    }
    places |= {f"kerb {kerb.kerb_id}": list(kerb.points) for kerb in road_map.kerbs}
    places |= {f"sign {sign.sign_id}": [at(sign.lane_id, sign.s_m)] for sign in road_map.signs}
    places |= {f"building {k}": list(one.outline) for k, one in enumerate(road_map.buildings)}
    return places


def topology(road_map: RoadMap) -> dict[str, tuple[str, ...]]:
    return {lane.lane_id: lane.successors for lane in road_map.lanes}
