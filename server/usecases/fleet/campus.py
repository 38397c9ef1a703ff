"""The campus map in force, and its stops."""

from functools import lru_cache

from contract.roads.load import MapError, decode_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.validate import problems
from server.domain.errors import MapInvalid, MapUnknown
from server.domain.roads.maps import StoredMap
from server.domain.roads.stops import CampusStop
from server.usecases.fleet import departures, map_changes
from server.usecases.fleet.service import enter_services
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event


def load_map(uow: UnitOfWork, content: bytes, by: str, *, activate: bool = False) -> StoredMap:
    """Store a map by its version; a repeat gives the stored one. Raises MapInvalid, MapInUse."""
    road_map = _decoded(content)
    stored = uow.maps.get(road_map.map_version)
    if stored is None:
        _require_sound(uow, road_map)
        stored = StoredMap(uow.campus_id, road_map.map_version, road_map.name, content, uow.now)
        uow.maps.add(stored)
        record_event(uow, "map.stored", road_map.map_version, by, road_map.name)
    return activate_map(uow, stored.map_version, by) if activate else stored


def load_map_at_start(uow: UnitOfWork, content: bytes) -> StoredMap:
    """Store the map that the server was started with, and activate it where it is new.

    A file that was loaded before does not replace a map that was published since: a restart is no roll-back.
    Raises MapInvalid, MapInUse.
    """
    version = _decoded(content).map_version
    is_new = uow.maps.get(version) is None or uow.maps.active_version() is None
    return load_map(uow, content, "start-up", activate=is_new)


@lru_cache(maxsize=1)
def _decoded(content: bytes) -> RoadMap:
    """A start asks for the same map several times, and a map never changes. Raises MapInvalid."""
    try:
        return decode_map(content)
    except MapError as error:
        raise MapInvalid(error.detail) from error


def activate_map(uow: UnitOfWork, map_version: str, by: str) -> StoredMap:
    """Make a stored map the one in force; every vehicle learns of it over its link.

    Raises MapUnknown, MapInUse (a shuttle is under way on what the map changes).
    """
    stored = uow.maps.get(map_version)
    if stored is None:
        raise MapUnknown(f"no map {map_version} is stored; import it first")
    if stored.active:
        return stored
    if uow.maps.active_version() is not None:
        after = uow.roads_at(map_version)
        assert after is not None, "it is stored"
        map_changes.take_to(uow, uow.roads(), after)
    uow.maps.activate(map_version)
    uow.roads_changed()
    enter_services(uow, uow.network().road_map)
    departures.note_unserved(uow)
    record_event(uow, "map.activated", map_version, by, stored.name)
    uow.publish(topics.campus_map(uow.campus_id), map_version=map_version)
    activated = uow.maps.get(map_version)
    return stored if activated is None else activated


def stops(uow: UnitOfWork) -> tuple[CampusStop, ...]:
    """The active map's stops in map order. Raises CampusUnknown."""
    return stops_of(uow.network())


def stops_of(network: RoadNetwork) -> tuple[CampusStop, ...]:
    """Any map's stops in map order."""
    found = []
    for stop in network.road_map.stops:
        x_m, y_m, _ = network.pose(stop.lane_id, stop.s_m)
        found.append(
            CampusStop(
                stop_id=stop.stop_id,
                name=stop.name,
                name_en=stop.name_en,
                lane_id=stop.lane_id,
                s_m=stop.s_m,
                x_m=x_m,
                y_m=y_m,
                placed_by=stop.placed_by,
            )
        )
    return tuple(found)


def _require_sound(uow: UnitOfWork, road_map: RoadMap) -> None:
    if road_map.campus_id != uow.campus_id:
        raise MapInvalid(f"the map is of campus {road_map.campus_id}, this server runs {uow.campus_id}")
    found = problems(road_map)
    if found:
        first = found[0]
        raise MapInvalid(
            f"the map has {len(found)} problems, the first at {first.where}: {first.detail}; "
            "see all with `campusloop map check`"
        )
