"""Decoded maps, kept for the life of the process: a version never changes."""

import threading

from contract.roads.load import MapError, decode_map
from contract.roads.network import RoadNetwork
from server.domain.errors import MapInvalid
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads


class MapLibrary:
    """Shared by all transactions, whatever thread they run in."""

    def __init__(self, rules: FleetRules) -> None:
        self._rules = rules
        self._roads: dict[str, FleetRoads] = {}
        self._lock = threading.Lock()

    def known(self, map_version: str) -> FleetRoads | None:
        return self._roads.get(map_version)

    def decode(self, content: bytes) -> FleetRoads:
        """Raises MapInvalid for bytes that are no road map."""
        with self._lock:
            try:
                road_map = decode_map(content)
            except MapError as error:
                raise MapInvalid(error.detail) from error
            known = self._roads.get(road_map.map_version)
            if known is None:
                rules = self._rules
                network = RoadNetwork(road_map, keep_points=False)
                known = FleetRoads(network, rules.speed_cap_mps, rules.travel_time_factor)
                self._roads[road_map.map_version] = known
            return known
