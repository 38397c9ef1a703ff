"""Sources, recorded and live, are checked: broken ones by the code of what is wrong, sound ones without."""

import os
import pty
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.operations.sensor_check import SourceNameError, listen, open_source
from tests.vehicle_agent.lidar.packet_bytes import NOON, hesai_packets, square_room
from tests.vehicle_agent.lidar.sick_telegrams import telegram
from tests.vehicle_agent.receivers.vectornav_bytes import common
from vehicle_agent.lidar.models import XT16
from workshop.sensors.inertial_source import InertialCheck
from workshop.sensors.lidar_source import PacketCheck
from workshop.sensors.source_report import Arrivals

NOON_NS = int(NOON.timestamp()) * 10**9
PACKETS = hesai_packets(XT16, 1_300, square_room(5.0))
PERIOD_NS = 100_000_000


def packet_report(packets: list[tuple[int, bytes]], late_ns: int = 4_000_000) -> Any:
    check = PacketCheck()
    for stamp_ns, data in packets:
        check.add(NOON_NS + stamp_ns + late_ns, data)
    return check.report("lidar")


def test_a_sound_lidar_has_rate_latency_and_no_finding() -> None:
    report = packet_report(PACKETS)
    # A square room is the same in every turn: a frozen sensor, for all that can be seen.
    assert [finding.split(":")[0] for finding in report.findings] == ["frozen"]
    assert (report.what, report.clock) == ("XT16", "set")
    assert report.rate_hz == pytest.approx(10.0, rel=0.01)
    assert report.latency_ms == pytest.approx(4.0, abs=0.1)


def test_a_clock_that_was_never_set_is_stated() -> None:
    report = packet_report(PACKETS, late_ns=3_600 * 10**9)
    assert report.clock == "off by -3600.0 s"
    assert report.latency_ms is None


def test_lost_packets_strangers_and_silence_are_found() -> None:
    assert packet_report([]).findings == ("silent",)
    broken = [*PACKETS[:100], (0, b"\xee\xff\x06\x01"), (0, b"unlike any"), *PACKETS[100:]]
    findings = packet_report(broken).findings
    assert "cut_packet: 1" in findings
    assert "unknown_model: 1" in findings


@pytest.mark.parametrize(
    ("arrived", "codes"),
    [
        ([k * PERIOD_NS for k in range(50)], []),
        ([k * PERIOD_NS for k in range(50) if not 20 < k < 30], ["gaps"]),
        ([k * 10 * PERIOD_NS for k in range(50)], ["rate"]),
        ([0, 2 * PERIOD_NS, PERIOD_NS, *(k * PERIOD_NS for k in range(3, 50))], ["out_of_order"]),
        ([], ["silent"]),
        ([5], []),
    ],
)
def test_times_tell_of_gaps_rates_and_order(arrived: list[int], codes: list[str]) -> None:
    arrivals = Arrivals(arrived)
    assert [finding.split(":")[0] for finding in arrivals.findings(4.5, 25.0)] == codes


def epoch(second: int, latitude_deg: float) -> bytes:
    pynmeagps = pytest.importorskip("pynmeagps", reason="needs the extra `workshop`")
    import datetime

    place = {
        "time": datetime.time(12, 0, second), "lat": latitude_deg, "NS": "N", "lon": 121.39, "EW": "E",
    }  # fmt: skip
    data: bytes = pynmeagps.NMEAMessage(
        "GN", "RMC", 0, **place, status="A", spd=4.0, cog=0.0, date=datetime.date(2026, 5, 4)
    ).serialize()
    data += pynmeagps.NMEAMessage("GN", "GGA", 0, **place, quality=4, numSV=12, HDOP=0.3).serialize()
    return data


def run(*arguments: str) -> tuple[int, str]:
    ran = CliRunner().invoke(app_of(["sensors"]), ["sensors", "check", *arguments])
    return ran.exit_code, ran.output


def test_a_recorded_receiver_is_checked_and_its_jump_found(tmp_path: Path) -> None:
    pytest.importorskip("pyubx2", reason="needs the extra `workshop`")
    sound = b"".join(epoch(second, 31.315 + 2e-5 * second) for second in range(20))
    (tmp_path / "sound.nmea").write_bytes(sound)
    code, output = run(str(tmp_path / "sound.nmea"))
    assert (code, "1.00" in output) == (0, True), output
    (tmp_path / "jump.nmea").write_bytes(sound + epoch(20, 31.325) + b"$GNRMC,garbage*00\r\n")
    code, output = run(str(tmp_path / "jump.nmea"))
    assert code == 1
    assert "jump: 1" in output
    assert "bad_checksum: 1" in output
    (tmp_path / "noise.nmea").write_bytes(b"\x00noise\n" * 50)
    code, output = run(str(tmp_path / "noise.nmea"))
    assert code == 1
    assert "no_position" in output


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    assert run(str(tmp_path / "none.pdf"))[0] == 2
    assert run(str(tmp_path / "none.nmea"))[0] == 2
    for name in (
        "lidar:udp:x",
        "scanner:udp:2111",
        "scanner:tcp:127.0.0.1:9",
        "gnss:tcp:127.0.0.1",
        "lidar:/dev/null",
        "gnss:udp:99999999",
        "gnss:/nowhere/tty",
    ):
        code, output = run(name)
        assert code == 2, output


def test_a_live_lidar_and_a_live_receiver_are_listened_to() -> None:
    pytest.importorskip("pyubx2", reason="needs the extra `workshop`")
    lidar = open_source("lidar:udp:0")
    server = socket.create_server(("127.0.0.1", 0))
    receiver = open_source(f"gnss:tcp:127.0.0.1:{server.getsockname()[1]}")
    connection, _ = server.accept()

    def send() -> None:
        # First what is counted: the packets of a loaded machine may come later than anyone listens.
        for second in range(3):
            connection.sendall(epoch(second, 31.315))
            time.sleep(0.02)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for number, (_, data) in enumerate(PACKETS[:800]):
            sender.sendto(data, ("127.0.0.1", lidar.source.port))
            if number % 20 == 0:
                time.sleep(0.004)
        sender.close()
        connection.close()

    thread = threading.Thread(target=send)
    thread.start()
    reports = listen([lidar, receiver], 1.5)
    thread.join()
    server.close()
    for live in (lidar, receiver):
        live.source.close()
    assert [report.what for report in reports] == ["XT16", "GNSS receiver"]
    assert reports[0].messages >= 1
    assert reports[1].messages == 3
    assert reports[1].clock.startswith("off by")


def test_a_live_planar_scanner_is_asked_for_turns_and_what_is_wrong_is_found() -> None:
    server = socket.create_server(("127.0.0.1", 0))
    scanner = open_source(f"scanner:tcp:127.0.0.1:{server.getsockname()[1]}")
    connection, _ = server.accept()
    assert connection.recv(100) == b"\x02sEN LMDscandata 1\x03"

    def send() -> None:
        for number in range(30):
            if number != 10:
                raw = [4_000 if number < 20 else 0] * 541
                connection.sendall(telegram(raw, counter=number, status=2 if number == 5 else 0))
            time.sleep(0.02)
        connection.sendall(b"\x02sSN LMDscandata 1 1\x03")
        connection.close()

    thread = threading.Thread(target=send)
    thread.start()
    (report,) = listen([scanner], 1.5)
    thread.join()
    server.close()
    scanner.source.close()
    assert report.what == "planar scanner, -135 to 135 degrees in steps of 0.50"
    assert report.messages == 29
    assert set(report.findings) >= {
        "cut_short: 1",
        "few_returns: 10",
        "lost_turns: 1",
        "pollution_warning: 1",
    }


def test_a_port_that_is_taken_and_a_receiver_that_is_away_are_named() -> None:
    pytest.importorskip("pyubx2", reason="needs the extra `workshop`")
    taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    taken.bind(("", 0))
    port = taken.getsockname()[1]
    with pytest.raises(SourceNameError, match=f"UDP port {port}"):
        open_source(f"lidar:udp:{port}")
    taken.close()
    with pytest.raises(SourceNameError, match="does not answer"):
        open_source(f"gnss:tcp:127.0.0.1:{port}")


def inertial_report(*samples: tuple[float, float, float]) -> Any:
    check = InertialCheck()
    for number, accel in enumerate(samples):
        check.add(NOON_NS + number * 10_000_000, common(accel))
    return check.report("imu")


def test_an_inertial_sensor_shows_gravity_or_is_named() -> None:
    sound = [(0.01 * (k % 3), 0.0, -9.8) for k in range(50)]
    assert inertial_report(*sound).findings == ()
    assert inertial_report(*sound).rate_hz == pytest.approx(100.0)
    [in_g] = inertial_report(*[(0.001 * (k % 3), 0.0, -1.0) for k in range(50)]).findings
    assert in_g.startswith("gravity: 1.00 m/s2")
    assert inertial_report(*[(0.0, 0.0, -9.8)] * 50).findings == ("frozen: 50 equal samples",)
    check = InertialCheck()
    check.add(NOON_NS, b"$VNYMR,1,2,3*00\r\n")
    assert check.report("imu").findings[0].startswith("no_samples")


def test_a_vehicles_own_sensors_are_checked_by_its_file(tmp_path: Path) -> None:
    """As its agent would read them: names, ports and a serial line of this speed."""
    pytest.importorskip("pyubx2", reason="needs the extra `workshop`")
    ours, theirs = pty.openpty()
    place = "place = { x_m = 0.0, y_m = 0.0, z_m = 2.0 }\n"
    path = tmp_path / "sensors.toml"
    path.write_text(
        f'[lidars.roof]\nlisten = "udp:{free_port()}"\n{place}'
        f'[inertial.vn]\nsource = "{os.ttyname(theirs)}"\nbaud = 115200\n{place}'
    )
    with ThreadPoolExecutor(1) as beside:
        ran = beside.submit(run, str(path), "--seconds", "1")
        while not ran.done():
            os.write(ours, common((0.0, 0.0, -9.8)))
            time.sleep(0.01)
    code, output = ran.result()
    os.close(ours)
    os.close(theirs)
    assert code == 1
    assert "roof: silent" in output
    assert "VectorNav" in output
    assert "vn: no_samples" not in output


def test_a_vehicle_whose_agent_runs_is_not_checked_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "sensors.toml"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("", 0))
        path.write_text(
            f'[lidars.roof]\nlisten = "udp:{taken.getsockname()[1]}"\n'
            "place = { x_m = 0.0, y_m = 0.0, z_m = 2.0 }\n"
        )
        code, output = run(str(path))
    assert code == 2
    assert "does the vehicle's agent run?" in output
    assert run(str(tmp_path / "none.toml"))[0] == 2


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("", 0))
        port: int = free.getsockname()[1]
        return port
