"""`campusloop infrastructure watch`: what it says of wrong options, and that vehicles get its reports."""

import socket
import sys
from pathlib import Path

import msgspec
import pytest
from typer.testing import CliRunner

from campusloop.commands.infrastructure import app
from contract.wire.messages import PresenceReport
from tests.campusloop.crossing_cameras.test_watch import a_picture, a_video

POINTS = ["0,120=-3.3,9", "320,120=3.3,9", "0,235=-3.3,7", "320,235=3.3,7"]
OUTLINE = ["--outline", "-2.5,6.8 2.5,6.8 2.5,9 -2.5,9"]


def run(source: str, *more: str, points: list[str] = POINTS) -> tuple[int, str]:
    options = [part for point in points for part in ("--point", point)]
    result = CliRunner().invoke(
        app, ["watch", source, "--area", "crossing", "--once", "--rate", "10", *options, *more]
    )
    return result.exit_code, result.output


@pytest.mark.parametrize(
    ("more", "points", "says"),
    [
        ((), POINTS, "give --map with the area, or its --outline"),
        (("--outline", "1,2 3"), POINTS, "give X,Y"),
        (("--map", "absent.json"), POINTS, "absent.json"),
        (OUTLINE, POINTS[:3], "at least four points"),
        (OUTLINE, ["0,0=a,b", *POINTS[1:]], "give U,V=X,Y in numbers"),
        ((*OUTLINE, "--vehicle", "nowhere"), POINTS, "give HOST:PORT"),
        ((*OUTLINE, "--server", "http://127.0.0.1:9"), POINTS, "no developer token"),
    ],
)
def test_wrong_options_say_what_to_give(more: tuple[str, ...], points: list[str], says: str) -> None:
    code, output = run("video.avi", *more, points=points)
    assert code == 2
    assert says in output


def test_an_absent_video_is_told(tmp_path: Path) -> None:
    code, output = run(str(tmp_path / "absent.avi"), *OUTLINE)
    assert code == 1
    assert "there is no video file" in output


def test_without_opencv_the_command_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    code, output = run("video.avi", *OUTLINE)
    assert code == 2
    assert "make camera" in output


def test_a_vehicle_gets_a_report_of_each_picture(tmp_path: Path) -> None:
    video = a_video(tmp_path / "crossing.avi", [a_picture(k, k >= 3) for k in range(7)])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(("127.0.0.1", 0))
        vehicle.settimeout(5.0)
        code, output = run(video, *OUTLINE, "--vehicle", f"127.0.0.1:{vehicle.getsockname()[1]}")
        received = [decoded(vehicle.recv(2000)) for _ in range(7)]
    assert code == 0
    assert "has ended after 7 pictures; 7 reports" in output
    assert {report.area_id for report in received} == {"crossing"}
    assert received[0].count == 0
    assert received[-1].count == 1


def decoded(data: bytes) -> PresenceReport:
    return msgspec.json.decode(data, type=PresenceReport)
