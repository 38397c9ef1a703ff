"""The port `MapWorkshop` of the use cases, over the importers."""

from functools import lru_cache
from pathlib import Path

from msgspec.structs import replace

from contract.roads.load import MapError
from contract.roads.model import RoadMap
from server.domain.errors import MapInvalid
from server.feeds.roads.exchange.formats import EXPORTS, draft_of, import_map
from server.feeds.roads.fixes import FIXES, mended
from server.feeds.roads.import_osm import ImportOptions
from server.usecases.ports.maps import ExportFormat


class RoadMapWorkshop:
    def imported(self, path: Path, like: RoadMap | None, campus_id: str) -> tuple[RoadMap, tuple[str, ...]]:
        name, timezone = ("Campus", "UTC") if like is None else (like.name, like.timezone)
        try:
            report = import_map(path, ImportOptions(campus_id=campus_id, name=name, timezone=timezone))
        except MapError as error:
            raise MapInvalid(f"{error.code}: {error.detail}") from error
        # A map of another server's campus may be used here.
        return replace(report.map, campus_id=campus_id), (*report.repairs, *report.dropped)

    def completed(self, road_map: RoadMap) -> RoadMap:
        return _completed(road_map)

    def exported(self, road_map: RoadMap, kind: ExportFormat) -> bytes:
        return EXPORTS[kind](road_map)

    def mends(self, code: str) -> bool:
        return code in FIXES

    def mended(self, road_map: RoadMap, code: str, where: str) -> RoadMap:
        return mended(road_map, code, where)


@lru_cache(maxsize=1)
def _completed(road_map: RoadMap) -> RoadMap:
    """Takes seconds. The map that was checked last is the one that is published or drawn next."""
    return draft_of(road_map).map
