"""A made-up city of long streets, and vehicles that stand on them.

The streets are a grid of three by three crossings, long enough that no more than a few vehicles are within
the 60 m in which vehicles receive each other's positions, as in a real city.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

from contract.geometry import Pose2
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from server.feeds.roads.import_osm import ImportOptions, import_osm

CAMPUS_ID = "benchmark-city"
_CROSSINGS = 3
_STREETS = 12
_DEGREES_PER_M = 1.0 / 111_195.0
_FROM_CROSSING_M = 40.0


@dataclass(frozen=True, slots=True)
class Place:
    """Where a vehicle stands; map frame."""

    lane_id: str
    s_m: float
    pose_map: Pose2


def city_map(vehicles: int, apart_m: float) -> RoadMap:
    """Streets on whose lanes that many vehicles stand so far apart."""
    street_m = max(300.0, vehicles * apart_m / (2 * _STREETS) + 2 * _FROM_CROSSING_M)
    with tempfile.TemporaryDirectory(prefix="campusloop-city-") as folder:
        path = Path(folder) / "city.osm"
        path.write_text(_osm(street_m), encoding="utf-8")
        options = ImportOptions(campus_id=CAMPUS_ID, name="Benchmark city", attribution="made up")
        return import_osm(path, options).map


def write_city(path: Path, vehicles: int, apart_m: float) -> None:
    path.write_bytes(encode_map(city_map(vehicles, apart_m)))


def places(road_map: RoadMap, vehicles: int) -> list[Place]:
    """So many places on the streets, evenly spread."""
    network = RoadNetwork(road_map)
    streets = [lane.lane_id for lane in road_map.lanes if network.lines[lane.lane_id].length_m > 200.0]
    free_m = [network.lines[lane_id].length_m - 2 * _FROM_CROSSING_M for lane_id in streets]
    apart_m = sum(free_m) / vehicles
    found: list[Place] = []
    at_m = 0.5 * apart_m
    for lane_id, length_m in zip(streets, free_m, strict=True):
        while at_m < length_m and len(found) < vehicles:
            s_m = _FROM_CROSSING_M + at_m
            found.append(Place(lane_id, s_m, Pose2(*network.pose(lane_id, s_m))))
            at_m += apart_m
        at_m -= length_m
    return found


def resting_places(road_map: RoadMap, network: RoadNetwork) -> list[Place]:
    return [
        Place(place.lane_id, place.s_m, Pose2(*network.pose(place.lane_id, place.s_m)))
        for place in road_map.resting_places
    ]


def _osm(street_m: float) -> str:
    """OpenStreetMap XML: two lanes on each street between neighbouring crossings."""
    step = street_m * _DEGREES_PER_M
    nodes = {(i, j): 1 + i * _CROSSINGS + j for i in range(_CROSSINGS) for j in range(_CROSSINGS)}
    lines = ['<?xml version="1.0"?>', '<osm version="0.6">']
    lines += [
        f'<node id="{node_id}" lat="{i * step:.9f}" lon="{j * step:.9f}" version="1"/>'
        for (i, j), node_id in nodes.items()
    ]
    streets = [
        (here, nodes[i + di, j + dj])
        for (i, j), here in nodes.items()
        for di, dj in ((1, 0), (0, 1))
        if (i + di, j + dj) in nodes
    ]
    for number, (first, last) in enumerate(streets):
        lines.append(
            f'<way id="{1000 + number}" version="1"><nd ref="{first}"/><nd ref="{last}"/>'
            f'<tag k="highway" v="residential"/><tag k="lanes" v="2"/><tag k="width" v="8"/>'
            f'<tag k="name" v="Street {number + 1}"/></way>'
        )
    return "\n".join([*lines, "</osm>", ""])
