"""A vehicle keeps scans inside the asked area, thinned by its way, in parcels of bounded size."""

import errno
import json
from pathlib import Path

import numpy as np
import pytest

from contract.roads.model import Origin
from contract.scan_parcels import parcels as parcel_files
from contract.scan_parcels.parcels import FixRow, ParcelHeader, PoseRow, checked_parcel
from contract.wire.scans import AreaCorner, ScanArea
from vehicle_agent.runtime.recording import scan_keeper, scan_parcels
from vehicle_agent.runtime.recording.scan_keeper import ScanKeeper
from vehicle_agent.runtime.recording.scan_parcels import VehicleFrame

FRAME = VehicleFrame("shuttle-1", "snow-lion", Origin(31.0, 121.0), "map-1", "points-1")
SQUARE = tuple(AreaCorner(x_m, y_m) for x_m, y_m in ((10.0, -5.0), (30.0, -5.0), (30.0, 5.0), (10.0, 5.0)))
LATER_NS = 1 << 62
STEP_NS = 100_000_000
SPEED_MPS = 4.0


def area(**changes: object) -> ScanArea:
    values: dict[str, object] = {
        "request_id": "scans-1", "outline": SQUARE, "every_m": 0.5, "bytes_max": 1 << 40,
        "until_ns": LATER_NS,
    }  # fmt: skip
    return ScanArea(**(values | changes))  # type: ignore[arg-type]


def rows(timed: bool = False) -> np.ndarray:
    rng = np.random.default_rng(1)
    found = np.zeros((2_000, 5), dtype=np.float32)
    found[:, :3] = rng.uniform(-20.0, 20.0, (2_000, 3))
    found[:, 4] = np.linspace(-0.1, 0.0, 2_000) if timed else 0.0
    return found


class Vehicle:
    """Drives along y = 0 with a scan every 0.1 s; a pose and a fix every 0.2 s."""

    def __init__(self, folder: Path, free_bytes: int = 1 << 50) -> None:
        self.folder = folder
        self.free_bytes = free_bytes
        self.keeper = ScanKeeper(folder, "scans-7", lambda: FRAME, lambda _: self.free_bytes)
        self.now_ns = 5_000_000_000_000
        self.rows = rows()

    def drive(self, from_m: float, to_m: float, lost: bool = False) -> None:
        steps = round((to_m - from_m) / (SPEED_MPS * STEP_NS * 1e-9))
        for number in range(steps + 1):
            x_m = from_m + number * SPEED_MPS * STEP_NS * 1e-9
            if number % 2 == 0 and not lost:
                pose = PoseRow(self.now_ns, x_m, 0.0, 0.0, SPEED_MPS)
                fix = FixRow(self.now_ns, 31.0, 121.0 + 1e-5 * x_m, 0.02)
                self.keeper.add_track((pose,), (fix,))
            self.keeper.look(self.now_ns)
            if self.keeper.is_wanted(self.now_ns, self.now_ns):
                self.keeper.take(self.now_ns, self.rows, self.now_ns)
            self.now_ns += STEP_NS

    def parcels(self) -> list[ParcelHeader]:
        found = [checked_parcel(path) for path in self.folder.glob("*/*.zip")]
        return sorted(found, key=lambda header: header.first_ns)

    @property
    def state(self) -> str:
        return self.keeper.reports()[-1].state


@pytest.fixture
def vehicle(tmp_path: Path) -> Vehicle:
    return Vehicle(tmp_path / "scans")


def test_scans_inside_the_area_become_a_parcel_when_the_vehicle_leaves_it(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 20.0)
    assert vehicle.state == "collecting"
    assert vehicle.parcels() == []
    vehicle.drive(20.4, 40.0)
    assert vehicle.state == "waiting"
    (header,) = vehicle.parcels()
    assert (header.request_id, header.vehicle_id, header.map_version) == ("scans-1", "shuttle-1", "map-1")
    # Every 0.8 m: a scan comes every 0.4 m, and 0.5 m are asked for.
    assert header.scans == pytest.approx(25, abs=1)
    assert header.way_m == pytest.approx(19.5, abs=1.0)


def test_a_standing_vehicle_keeps_one_scan(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.keeper.add_track((PoseRow(vehicle.now_ns, 20.0, 0.0, 0.0, 0.0),), ())
    for number in range(8):
        stamp_ns = vehicle.now_ns + number * STEP_NS
        if vehicle.keeper.is_wanted(stamp_ns, stamp_ns):
            vehicle.keeper.take(stamp_ns, vehicle.rows, stamp_ns)
    vehicle.keeper.close()
    (header,) = vehicle.parcels()
    assert header.scans == 1


def test_each_pass_of_the_area_is_a_drive_of_its_own(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    for _ in range(2):
        vehicle.drive(0.0, 40.0)
    drives = [header.drive_id for header in vehicle.parcels()]
    assert len(set(drives)) == 2
    (report,) = vehicle.keeper.reports()
    assert report.totals.drives == 2
    assert report.totals.scans == sum(header.scans for header in vehicle.parcels())
    assert report.totals.bytes_kept == sum(path.stat().st_size for path in vehicle.folder.glob("*/*.zip"))


def test_a_full_parcel_is_followed_by_another_one_of_the_same_drive(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scan_parcels, "PARCEL_SCANS", 10)
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 40.0)
    headers = vehicle.parcels()
    assert [header.number for header in headers] == [0, 1, 2]
    assert len({header.drive_id for header in headers}) == 1


def test_nothing_is_kept_without_a_pose_and_none_is_guessed(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(outline=()),), vehicle.now_ns)
    vehicle.drive(0.0, 10.0, lost=True)
    assert vehicle.state == "waiting"
    vehicle.drive(10.0, 14.0)
    assert vehicle.state == "collecting"
    vehicle.drive(14.4, 30.0, lost=True)
    assert vehicle.state == "waiting"
    (header,) = vehicle.parcels()
    # A second further on by its speed, and no more.
    assert header.way_m < 9.0


def test_a_request_that_has_ended_leaves_a_whole_parcel(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 20.0)
    vehicle.keeper.set_requests((), vehicle.now_ns)
    (header,) = vehicle.parcels()
    assert not vehicle.keeper.is_busy
    (report,) = vehicle.keeper.reports()
    assert (report.state, report.totals.scans) == ("ended", header.scans)
    assert report.totals.bytes_kept > 0
    assert vehicle.keeper.reports() == ()


def test_it_ends_by_its_time_and_by_its_size(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(until_ns=vehicle.now_ns + 40 * STEP_NS),), vehicle.now_ns)
    vehicle.drive(0.0, 25.0)
    assert vehicle.state == "ended"
    assert len(vehicle.parcels()) == 1
    vehicle.keeper.set_requests((), vehicle.now_ns)
    vehicle.keeper.set_requests((area(request_id="scans-2", bytes_max=1),), vehicle.now_ns)
    vehicle.drive(0.0, 40.0)
    vehicle.drive(0.0, 40.0)
    assert vehicle.state == "ended"
    assert len(vehicle.parcels()) == 2


def test_a_disk_without_room_is_told_and_it_goes_on_once_there_is_some(vehicle: Vehicle) -> None:
    vehicle.free_bytes = 10
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 20.0)
    (report,) = vehicle.keeper.reports()
    assert (report.state, report.detail) == ("disk_full", "10 bytes of the disk are free")
    assert vehicle.parcels() == []
    vehicle.free_bytes = 1 << 50
    vehicle.now_ns += scan_keeper.LOOK_NS
    vehicle.drive(11.0, 40.0)
    assert len(vehicle.parcels()) == 1


def test_scans_that_wait_for_their_upload_take_no_more_than_their_share(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 40.0)
    monkeypatch.setattr(scan_keeper, "KEPT_BYTES_MAX", 100_000)
    vehicle.now_ns += scan_keeper.LOOK_NS
    vehicle.drive(0.0, 20.0)
    assert vehicle.state == "disk_full"
    for path in vehicle.folder.glob("*/*.zip"):
        path.unlink()
    monkeypatch.setattr(scan_keeper, "KEPT_BYTES_MAX", 1 << 40)
    vehicle.now_ns += scan_keeper.LOOK_NS
    vehicle.drive(11.0, 40.0)
    assert len(vehicle.parcels()) == 1


def test_a_write_that_fails_loses_the_open_parcel_alone_and_is_told(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 40.0)

    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(parcel_files.ParcelWriter, "add_scan", full)
        vehicle.drive(0.0, 20.0)
    (report,) = vehicle.keeper.reports()
    assert report.state == "disk_full"
    assert "No space left" in report.detail
    assert len(list(vehicle.folder.glob("*/*"))) == 1
    vehicle.drive(11.0, 40.0)
    assert len(vehicle.parcels()) == 2


def test_a_silent_lidar_is_told(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.keeper.look(vehicle.now_ns + 2 * scan_keeper.SILENT_NS)
    assert vehicle.state == "no_scans"


def test_another_process_goes_on_counting_and_removes_what_was_half_written(vehicle: Vehicle) -> None:
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 40.0)
    vehicle.drive(0.0, 20.0)
    assert list(vehicle.folder.glob("*/*.part"))
    again = Vehicle(vehicle.folder)
    assert not list(vehicle.folder.glob("*/*.part"))
    again.keeper.set_requests((area(),), again.now_ns)
    (report,) = again.keeper.reports()
    assert report.totals.drives == 1
    assert json.loads((vehicle.folder / "scans-1.json").read_bytes())["drives"] == 1


def test_points_of_a_turning_lidar_keep_their_times(vehicle: Vehicle, tmp_path: Path) -> None:
    vehicle.rows = rows(timed=True)
    vehicle.keeper.set_requests((area(),), vehicle.now_ns)
    vehicle.drive(0.0, 40.0)
    (path,) = vehicle.folder.glob("*/*.zip")
    parcel_files.unpack(path, tmp_path / "drive")
    from workshop.clouds.recordings import find_recordings

    (recording,) = find_recordings(tmp_path / "drive")
    cloud = next(iter(recording.scans()))
    assert cloud.offsets_ns.min() == 0
    assert cloud.offsets_ns.max() == pytest.approx(100_000_000, abs=1_000_000)
    # The file's stamp is that of the first point: the ring has the time at which the turn was complete.
    since_ns = recording.stamp_ns(0) - 5_000_000_000_000
    assert since_ns == pytest.approx(STEP_NS * round(since_ns / STEP_NS), abs=10)
