"""A road map as bytes: deterministic JSON whose version is the hash of its content."""

import hashlib
from pathlib import Path

import msgspec

from contract.roads.model import FORMAT_VERSION, RoadMap

_VERSION_DIGITS = 16
# Later than format 1: not written when empty, so that maps without them keep their version.
_LATER_FIELDS = ("observation_areas", "no_stopping_zones", "kerbs", "signs")


class MapError(Exception):
    """A map that cannot be used: a stable code, and a detail that says what to do about it."""

    def __init__(self, code: str, detail: str) -> None:
        super().__init__(f"{code}: {detail}")
        self.code = code
        self.detail = detail


def content_version(road_map: RoadMap) -> str:
    """The first 16 hex digits of SHA-256 over the map's content without `map_version`."""
    content = _json(msgspec.structs.replace(road_map, map_version=""))
    return hashlib.sha256(content).hexdigest()[:_VERSION_DIGITS]


def _json(road_map: RoadMap) -> bytes:
    """A map without what came later is written as it was before there was any of it."""
    fields = msgspec.structs.asdict(road_map)
    for name in _LATER_FIELDS:
        if not fields[name]:
            del fields[name]
    return msgspec.json.encode(fields)


def with_version(road_map: RoadMap) -> RoadMap:
    """The same map carrying its content's version."""
    return msgspec.structs.replace(road_map, map_version=content_version(road_map))


def encode_map(road_map: RoadMap) -> bytes:
    """The map as JSON, equal bytes for equal content, `map_version` set."""
    return _json(with_version(road_map)) + b"\n"


def decode_map(data: bytes) -> RoadMap:
    """The map in these bytes, with `map_version` set.

    Raises MapError: map_empty, map_broken (not JSON, cut, or a field is wrong), map_format (written by
    another version of the program), map_altered (content and map_version disagree).
    """
    if not data.strip():
        raise MapError("map_empty", "the map file is empty; build it again with `campusloop map import`")
    try:
        road_map = msgspec.json.decode(data, type=RoadMap)
    except msgspec.ValidationError as error:
        raise MapError(
            "map_broken", f"not a road map: {error}; build it again with `campusloop map import`"
        ) from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise MapError(
            "map_broken",
            f"the map is cut or is not JSON: {error}; build it again with `campusloop map import`",
        ) from error
    if road_map.format_version != FORMAT_VERSION:
        raise MapError(
            "map_format",
            f"map format {road_map.format_version}, not {FORMAT_VERSION}: import the map again",
        )
    version = content_version(road_map)
    if road_map.map_version not in ("", version):
        raise MapError(
            "map_altered",
            f"content {version} under version {road_map.map_version}: the file was edited or damaged; "
            'build it again, or set its "map_version" to "" if the edit is wanted',
        )
    return msgspec.structs.replace(road_map, map_version=version)


def load_map(path: Path | str) -> RoadMap:
    """The map in a file; raises MapError as `decode_map` does, and map_missing."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise MapError(
            "map_missing",
            f"cannot read {path}: {error.strerror}; give a map built by `campusloop map import`",
        ) from error
    return decode_map(data)
