"""Downloads a published map, and checks that it is the announced one and can be driven by."""

import hashlib
from collections.abc import Callable

import httpx

from contract.roads.load import MapError, decode_map
from contract.roads.model import RoadMap
from contract.roads.validate import problems
from contract.wire.maps import MapFailure, MapPublished, map_path, signed_map_request
from contract.wire.upload import SIGNATURE_HEADER
from vehicle_agent.link.not_taken import NotTaken

# Between two parts of the answer: a server that dies in the middle is noticed.
TIMEOUT_S = 20.0


class MapNotTaken(NotTaken):
    """The vehicle keeps the road map that it has."""

    def __init__(self, code: MapFailure, detail: str) -> None:
        super().__init__(code, detail)


async def download_map(
    client: httpx.AsyncClient, vehicle_id: str, sign: Callable[[bytes], str], published: MapPublished
) -> bytes:
    """The announced bytes. Reads no more than were announced.

    client  with the server's base URL; sign: base64 of the vehicle key's signature
    Raises MapNotTaken: not_downloaded, damaged.
    """
    text = signed_map_request(vehicle_id, published.map_version)
    headers = {SIGNATURE_HEADER: sign(text), "Vehicle-Id": vehicle_id, "Accept-Encoding": "gzip"}
    data = bytearray()
    try:
        url = map_path(published.map_version)
        async with client.stream("GET", url, headers=headers, timeout=TIMEOUT_S) as response:
            if response.status_code != 200:
                answer = (await response.aread())[:300].decode(errors="replace")
                raise MapNotTaken("not_downloaded", f"the server answers {response.status_code}: {answer}")
            async for part in response.aiter_bytes():
                data += part
                if len(data) > published.size_bytes:
                    raise MapNotTaken("damaged", f"more than the announced {published.size_bytes} bytes came")
    except httpx.DecodingError as error:
        raise MapNotTaken("damaged", f"cannot be decompressed: {error}") from error
    except httpx.TransportError as error:
        cause = str(error) or type(error).__name__
        raise MapNotTaken("not_downloaded", f"broke off after {len(data)} bytes: {cause}") from error
    found = hashlib.sha256(data).hexdigest()
    if found != published.sha256:
        raise MapNotTaken("damaged", f"{len(data)} bytes of SHA-256 {found}, announced {published.sha256}")
    return bytes(data)


def checked_map(data: bytes, published: MapPublished, campus_id: str) -> RoadMap:
    """The map in announced bytes, sound by the rules by which every map is checked. Takes a second or so.

    Raises MapNotTaken: unsound.
    """
    try:
        road_map = decode_map(data)
    except MapError as error:
        raise MapNotTaken("unsound", str(error)) from error
    if road_map.map_version != published.map_version:
        raise MapNotTaken("unsound", f"it is map {road_map.map_version}, not {published.map_version}")
    if road_map.campus_id != campus_id:
        raise MapNotTaken("unsound", f"it is a map of campus {road_map.campus_id}, not of {campus_id}")
    found = problems(road_map)
    if found:
        raise MapNotTaken(
            "unsound", f"{len(found)} problems, the first at {found[0].where}: {found[0].detail}"
        )
    return road_map
