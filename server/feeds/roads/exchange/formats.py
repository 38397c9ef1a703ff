"""Maps in and out by format: the one place that knows all of them. A file's format is told by its content."""

from collections.abc import Callable, Mapping
from dataclasses import replace as replaced
from pathlib import Path
from typing import Literal

from msgspec.structs import replace

from contract.roads.load import MapError, decode_map, encode_map, with_version
from contract.roads.model import RoadMap
from contract.roads.validate import problems
from server.feeds.roads.derived import derived
from server.feeds.roads.exchange.geojson_reader import decode_geojson, is_ours, map_from_geojson
from server.feeds.roads.exchange.geojson_roads import osm_from_geojson
from server.feeds.roads.exchange.geojson_writer import geojson_of
from server.feeds.roads.exchange.lanelet_file import read_lanelet_file
from server.feeds.roads.exchange.lanelet_reader import header_in, map_from_lanelets
from server.feeds.roads.exchange.lanelet_roads import map_from_foreign_lanelets
from server.feeds.roads.exchange.lanelet_writer import lanelet2_of
from server.feeds.roads.import_osm import ImportOptions, ImportReport, import_data, import_osm
from server.feeds.roads.lanes.drafts import ImportLog

SourceFormat = Literal["osm", "geojson", "lanelet2", "map"]
ExportFormat = Literal["geojson", "lanelet2", "map"]
EXPORTS: Mapping[ExportFormat, Callable[[RoadMap], bytes]] = {
    "geojson": geojson_of,
    "lanelet2": lanelet2_of,
    "map": encode_map,
}
_BLOCK_BYTES = 1 << 20
_HEAD_BYTES = 200


def format_of(path: Path) -> SourceFormat:
    """What the file's content says. Raises MapError: osm_missing, map_empty."""
    try:
        with path.open("rb") as file:
            first = file.read(_BLOCK_BYTES)
            start = first.lstrip(b"\xef\xbb\xbf \t\r\n")[:1]
            if not first.strip():
                raise MapError("map_empty", f"{path.name} is empty; export it again")
            if start == b"{":
                head = first[:_HEAD_BYTES]
                is_map = b'"campus_id"' in head and b'"FeatureCollection"' not in head
                return "map" if is_map else "geojson"
            if start == b"<" and _mentions(first, file.read):
                return "lanelet2"
    except OSError as error:
        raise MapError(
            "osm_missing", f"cannot read {path}: {error.strerror}; check the file's name"
        ) from error
    return "osm"


def _mentions(block: bytes, read: Callable[[int], bytes]) -> bool:
    """A relation of type lanelet is in the file; such files have their relations last."""
    tail = b""
    while block:
        if b'v="lanelet"' in tail + block or b"v='lanelet'" in tail + block:
            return True
        tail, block = block[-16:], read(_BLOCK_BYTES)
    return False


def import_map(path: Path, options: ImportOptions = ImportOptions()) -> ImportReport:
    """A drivable map from OpenStreetMap, GeoJSON, Lanelet2 or a road map.

    Our own files keep their names and ids; a map that nobody changed keeps its version. Raises MapError with
    what to do, as the readers do, and unsound for a foreign file of which no sound map can be made.
    """
    source = format_of(path)
    if source == "osm":
        return import_osm(path, options)
    data, log = path.read_bytes(), ImportLog()
    if source == "map":
        return _report(decode_map(data), log)
    if source == "geojson":
        document = decode_geojson(data)
        if is_ours(document):
            return _report(map_from_geojson(document, log), log)
        # Only OpenStreetMap's own files oblige us to name it.
        foreign = replaced(options, attribution="")
        return import_data(osm_from_geojson(document, log), foreign, log)
    file = read_lanelet_file(data)
    header = header_in(file)
    if header is not None:
        return _report(map_from_lanelets(file, header, log), log)
    return _sound(_report(map_from_foreign_lanelets(file, options, log), log))


def draft_of(road_map: RoadMap) -> ImportReport:
    """A map that is being drawn, with what is derived made anew; it may have problems."""
    log = ImportLog()
    return _report(derived(replace(road_map, map_version=""), log), log)


def _report(road_map: RoadMap, log: ImportLog) -> ImportReport:
    """What was repaired now is told with the map, once."""
    told = tuple(line for line in log.repairs if line not in road_map.repairs)
    road_map = with_version(replace(road_map, repairs=(*road_map.repairs, *told)))
    return ImportReport(road_map, told, tuple(log.dropped))


def _sound(report: ImportReport) -> ImportReport:
    defects = problems(report.map)
    if defects:
        raise MapError("unsound", f"{defects[0].where}: {defects[0].detail}; mend the file, and try again")
    return report
