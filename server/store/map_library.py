"""Decoded maps, kept for the life of the process: a version never changes."""

import threading

from contract.roads.load import MapError, decode_map
from contract.roads.network import RoadNetwork
from server.domain.errors import MapInvalid


class MapLibrary:
    """Shared by all transactions, whatever thread they run in."""

    def __init__(self) -> None:
        self._networks: dict[str, RoadNetwork] = {}
        self._lock = threading.Lock()

    def known(self, map_version: str) -> RoadNetwork | None:
        return self._networks.get(map_version)

    def decode(self, content: bytes) -> RoadNetwork:
        """Raises MapInvalid for bytes that are no road map."""
        with self._lock:
            try:
                road_map = decode_map(content)
            except MapError as error:
                raise MapInvalid(error.detail) from error
            known = self._networks.get(road_map.map_version)
            if known is None:
                known = self._networks[road_map.map_version] = RoadNetwork(road_map)
            return known
