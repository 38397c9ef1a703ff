"""Packets of real models on real sockets become scans for the perception worker."""

import socket
from pathlib import Path

import numpy as np
import pytest

from contract.transforms import transform_of
from tests.vehicle_agent.lidar.packet_bytes import square_room, velodyne_packets
from vehicle_agent.device_feed import DatagramPort, DeviceValues, ScanReady, ScanRing
from vehicle_agent.lidar.models import VLP16
from vehicle_agent.perception.height_map import HeightMap, percept_from_scan
from vehicle_agent.runtime.processes.sensing import lidar_process
from vehicle_agent.runtime.processes.sensing.lidar_process import LidarProcess
from vehicle_agent.runtime.sensors.sensors_file import PlacedLidar
from vehicle_agent.signals import LidarCondition, LidarConditions

HOST = "127.0.0.1"
ROOF = transform_of(0.0, 0.0, 0.0, np.array([1.0, 0.0, 2.0]))
# Of 151 packets, two turns: the first one that is whole ends with the last of them.
HEIGHT_MAP = HeightMap(above_m=2.4, body_front_m=3.5, body_back_m=0.85, body_half_width_m=0.8)
PACKETS = [packet for _, packet in velodyne_packets(VLP16, 170, square_room(8.0))]


class Said:
    """What the process logs; the log of the test's own process is set by other tests."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.entries: list[dict[str, object]] = []
        monkeypatch.setattr(lidar_process, "log", self)

    def warning(self, event: str, **fields: object) -> None:
        self.entries.append({"event": event, **fields})

    info = warning


class Time:
    """A clock that a test moves."""

    def __init__(self) -> None:
        self.ns = 1_000_000_000

    def now_ns(self) -> int:
        return self.ns

    def utc_offset_ns(self) -> int:
        return 0

    def wait(self, due_ns: int, files: object = ()) -> None: ...

    def close(self) -> None: ...


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind((HOST, 0))
        port: int = free.getsockname()[1]
        return port


def test_packets_become_a_scan_and_its_obstacles(tmp_path: Path) -> None:
    port, worker, time = free_port(), DatagramPort(), Time()
    lidar = PlacedLidar("roof", port, ROOF, None, True)
    process = LidarProcess((lidar,), tmp_path / "scans", worker.port, worker.port, time)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sensor:
        for packet in PACKETS:
            sensor.sendto(packet, (HOST, port))
            time.ns += 1_330_000
            process.step()
    announced = [datagram for datagram in worker.take() if isinstance(datagram, ScanReady)]
    assert len(announced) >= 1
    scan = ScanRing(tmp_path / "scans", create=False).read(announced[-1])
    assert scan is not None
    points = scan[0]
    assert len(points) > 20_000
    # The walls are 8 m from the lidar, which is 1 m ahead of the axle.
    assert np.abs(points[:, 0] - 1.0).max() == pytest.approx(8.0, abs=0.1)
    percept = percept_from_scan(points, announced[-1].stamp_ns, HEIGHT_MAP)
    assert percept.points_used > 10_000


def test_a_lidar_that_falls_silent_makes_the_vehicle_blind_and_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker, time, said = DatagramPort(), Time(), Said(monkeypatch)
    process = LidarProcess(
        (PlacedLidar("roof", free_port(), ROOF, None, True),),
        tmp_path / "scans",
        worker.port,
        worker.port,
        time,
    )
    for _ in range(10):
        process.step()
        time.ns += 50_000_000
    received = worker.take()
    announced = [datagram for datagram in received if isinstance(datagram, ScanReady)]
    assert len(announced) == 1
    scan = ScanRing(tmp_path / "scans", create=False).read(announced[0])
    assert scan is not None
    assert percept_from_scan(scan[0], announced[0].stamp_ns, HEIGHT_MAP).points_used == 0
    assert [
        (entry["name"], entry["code"]) for entry in said.entries if entry["event"] == "lidar.missing"
    ] == [("roof", "silent")]
    stated = [item for one in received if isinstance(one, DeviceValues) for item in one.items]
    assert isinstance(stated[0], LidarConditions)
    assert stated[0].lidars == ()
    assert isinstance(stated[-1], LidarConditions)
    assert stated[-1].lidars == (LidarCondition("roof", "silent", is_required=True),)
    # Once when it changes, and not with each step.
    assert len(stated) == 2


def test_packets_of_no_lidar_are_named_and_nothing_stops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    port, worker, time, said = free_port(), DatagramPort(), Time(), Said(monkeypatch)
    process = LidarProcess(
        (PlacedLidar("roof", port, ROOF, None, True),), tmp_path / "scans", worker.port, worker.port, time
    )
    time.ns = 20_000_000_000
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sensor:
        for data in (b"", b"hello", bytes(1206), PACKETS[0][:700]):
            sensor.sendto(data, (HOST, port))
        process.step()
    [entry] = [entry for entry in said.entries if entry["event"] == "lidar.refused_packets"]
    assert sum(value for value in entry.values() if isinstance(value, int)) == 4
