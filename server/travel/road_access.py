"""Which sections of the map a shuttle may not enter: other shuttles' resting places, and closed roads."""

from contract.roads.network import RoadNetwork
from contract.roads.travel_times import Place
from server.travel.closed_roads import way_out

Own = frozenset[str]


class RoadAccess:
    """One map version with some sections closed. Every set is kept: neither of them changes."""

    def __init__(self, network: RoadNetwork, closed: frozenset[str]) -> None:
        self._network = network
        self._closed = closed
        self._kept_clear: dict[Own, frozenset[str]] = {}
        self._ways_out: dict[str, frozenset[str]] = {}

    def kept_clear(self, own: Own) -> frozenset[str]:
        """What the owner of these resting places may not drive through."""
        if own not in self._kept_clear:
            self._kept_clear[own] = self._network.kept_clear(own) | self._closed
        return self._kept_clear[own]

    def closed_for(self, section_id: str) -> frozenset[str]:
        """The closed sections that a vehicle which stands in this one may not enter: on closed road it may
        drive on to leave it."""
        return self._closed - self._way_out(section_id) if self._closed else self._closed

    def closed_from(self, place: Place, blocked: frozenset[str]) -> frozenset[str]:
        """What may not be entered on a way from a place: its own section is open, and the way off closed
        road."""
        section_id = self._network.section_at(*place).section_id
        shut = blocked - {section_id}
        return shut - self._way_out(section_id) if self._closed else shut

    def _way_out(self, section_id: str) -> frozenset[str]:
        if section_id not in self._ways_out:
            self._ways_out[section_id] = way_out(self._network, section_id, self._closed)
        return self._ways_out[section_id]
