"""The campus map in force, and its stops."""

from contract.roads.model import RoadMap
from server.domain.maps import StoredMap
from server.domain.stops import CampusStop
from server.usecases.ports import UnitOfWork


def load_map(uow: UnitOfWork, content: bytes, by: str, *, activate: bool = False) -> StoredMap:
    """Store a map by its version; a repeat gives the stored one. Raises MapInvalid, MapInUse."""
    raise NotImplementedError


def activate_map(uow: UnitOfWork, map_version: str, by: str) -> StoredMap:
    """Make a stored map the one in force. Raises MapUnknown, MapInUse (shuttles are under way)."""
    raise NotImplementedError


def active_map(uow: UnitOfWork) -> RoadMap:
    """Raises CampusUnknown."""
    raise NotImplementedError


def stops(uow: UnitOfWork) -> tuple[CampusStop, ...]:
    """The active map's stops in map order. Raises CampusUnknown."""
    raise NotImplementedError
