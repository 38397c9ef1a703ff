"""A campus with a vehicle that sends scans, and a loop that makes proposals by a builder of the test."""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import msgspec
import numpy as np

from contract.point_map.map_files import read_index
from contract.roads.model import Origin
from contract.scan_parcels.parcels import FixRow, ParcelHeader, ParcelWriter, PoseRow
from contract.scan_parcels.proposals import COMPARISON, PICTURE, Comparison, ProposedTile
from contract.wire.scans import parcel_path, signed_parcel
from contract.wire.upload import SIGNATURE_HEADER
from server.api.runs.offload import InlineOffload
from server.loops.scan_maps import ScanMapLoop
from server.usecases.ports.scans import MapBuilder
from tests.contract.localization_folders import point_map
from tests.server.api.server_under_test import CAMPUS, ServerUnderTest, snow_lion
from tests.server.fleet.vehicle_key import VehicleKeyPair

HERE = snow_lion().origin
PNG = b"\x89PNG\r\n\x1a\n, as small as pictures are"


def write_parcel(
    path: Path, request_id: str, vehicle_id: str = "shuttle-1", campus_id: str = CAMPUS, number: int = 0,
    origin: Origin = HERE, scans: int = 2,
) -> Path:  # fmt: skip
    writer = ParcelWriter(path)
    stamps = [5_000_000_000 + 100_000_000 * one for one in range(scans)]
    for stamp_ns in stamps:
        writer.add_scan(stamp_ns, np.ones((300, 3)))
    header = ParcelHeader(
        1, request_id, vehicle_id, campus_id, "scans-7-1", number, origin, "map-1", "", scans, 0.5,
        stamps[0], stamps[-1],
    )  # fmt: skip
    writer.finish(header, [FixRow(stamps[0], 22.8, 113.4, 0.02)], [PoseRow(stamps[0], 0.0, 0.0, 0.0, 4.0)])
    return path


def put_parcel(
    server: ServerUnderTest, data: bytes, vehicle_id: str = "shuttle-1", sha256: str = ""
) -> httpx.Response:
    sha256 = sha256 or hashlib.sha256(data).hexdigest()
    key = VehicleKeyPair(vehicle_id)
    headers = {"Vehicle-Id": vehicle_id, SIGNATURE_HEADER: key.sign(signed_parcel(vehicle_id, sha256))}
    return server.run(server.client.put(parcel_path(sha256), content=data, headers=headers))


class PreparedBuilder:
    """Answers with a small map; `in_force` is what it was given to compare with."""

    def __init__(self, changed: int = 1) -> None:
        """changed: tiles of the map that differ from those of another builder's."""
        self.changed = changed
        self.parcels: list[str] = []
        self.in_force = ""
        self.meanwhile: Callable[[], None] = lambda: None

    async def build(
        self, parcels: Path, in_force: Path | None, out: Path, tell: Callable[[str, int], None]
    ) -> None:
        self._build(parcels, in_force, out, tell)

    def _build(
        self, parcels: Path, in_force: Path | None, out: Path, tell: Callable[[str, int], None]
    ) -> None:
        self.parcels = sorted(path.name for path in parcels.iterdir())
        self.in_force = "" if in_force is None else read_index(in_force).map_version
        tell("odometry", 40)
        self.meanwhile()
        index = point_map(out, HERE, changed=self.changed)
        (out / PICTURE).write_bytes(PNG)
        said = comparison(index.map_version, self.in_force)
        (out / COMPARISON).write_bytes(msgspec.json.encode(said))


def comparison(map_version: str, in_force_version: str) -> Comparison:
    tiles = (
        ProposedTile(1, 0, 900, 20, 150, 4, 30, 0, 0.162, True, False, True),
        ProposedTile(0, 0, 1000, 2, 0, 0, 30, 0, 0.002, False, False, False),
    )
    return Comparison(
        map_version, in_force_version, 1, 2, 0.5, 0.011, 40, (0.01, -0.02, 0.1), 0.0002, 0.004, 0.015, 0.0848,
        tiles, 3, 9_000, ("Drive scans-7-2 was left out: it has one scan.",),
    )  # fmt: skip


def scan_map_loop(server: ServerUnderTest, builder: MapBuilder) -> ScanMapLoop:
    services = server.services
    return ScanMapLoop(
        server.transactions, server.bus, CAMPUS, InlineOffload(), services.scans, services.tiles, builder
    )


@contextmanager
def a_server(tmp_path: Path) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path, makes_maps=True)
    yield server
    server.close()
