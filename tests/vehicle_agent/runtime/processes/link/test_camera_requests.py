"""An operator's request for a camera, to the pictures that leave the vehicle, or the reason why none does."""

import io
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from contract.wire.messages import CameraPicture, Command
from vehicle_agent.picture_ring import PictureRing
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.link.camera_requests import CameraRequests
from vehicle_agent.runtime.processes.mailbox import Mailbox
from vehicle_agent.runtime.processes.sensing.video_process import VideoProcess
from vehicle_agent.runtime.video.camera_view import CameraShown
from vehicle_agent.runtime.video.cameras_file import Blur, CameraEntry, RecordedCamera, Upload, VideoSettings

WITHIN_S = 20.0
# A checkerboard of 4 pixels, which blocks of 20 turn into grey.
BOARD = np.kron(np.indices((30, 40)).sum(axis=0) % 2, np.ones((4, 4)))[..., None].repeat(3, axis=2)


class Vehicle:
    """A camera that sees a checkerboard, the process that records it, and the link's mail."""

    def __init__(self, folder: Path, upload: Upload, blur: Blur) -> None:
        self.ring = PictureRing(folder / "ring", create=True)
        camera = RecordedCamera("front", CameraEntry("ring", 160, 120), str(folder / "ring"))
        settings = VideoSettings((camera,), 5, upload=upload, blur=blur)
        self.link = Mailbox(folder / "mail" / "link")
        self.process = VideoProcess(settings, folder / "video", MONOTONIC, folder / "mail")
        self.pictures: list[CameraPicture] = []
        video = folder / "mail" / "video"
        post = self.link.post
        self.requests = CameraRequests(MONOTONIC, lambda one: post(video, one), self.pictures.append)

    def ask(self, camera: str) -> None:
        self.requests.hear(Command(1, "command-1", "show_camera", camera))

    def see(self, pictures: int, *, sees: bool = True) -> None:
        """Time passes until so many have come, or 2 s when none are to come."""
        until_s = time.monotonic() + (WITHIN_S if pictures else 2.0)
        while time.monotonic() < until_s and (not pictures or len(self.pictures) < pictures):
            if sees:
                self.ring.write(time.monotonic_ns(), (255 * BOARD).astype(np.uint8))
            time.sleep(0.1)
            self.process.show()
            self.pictures += [mail.picture for mail in self.link.take() if isinstance(mail, CameraShown)]

    def close(self) -> None:
        self.process.close()
        self.link.close()
        self.ring.close()


@pytest.fixture
def vehicle(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Vehicle]:
    pytest.importorskip("av", reason="PyAV is not installed (make video)")
    made = Vehicle(tmp_path, *getattr(request, "param", ("asked", "whole")))
    yield made
    made.close()


def contrast(picture: CameraPicture) -> float:
    """Standard deviation of the brightness, of 255."""
    import av

    with av.open(io.BytesIO(picture.jpeg)) as read:
        (decoded,) = read.decode(video=0)
    assert (decoded.width, decoded.height) == (160, 120)
    return float(decoded.to_ndarray(format="gray").std())


@pytest.mark.parametrize(
    ("vehicle", "is_coarse"), [(("asked", "none"), False), (("asked", "whole"), True)], indirect=["vehicle"]
)
def test_pictures_come_twice_a_second_and_show_what_the_policy_lets_out(
    vehicle: Vehicle, *, is_coarse: bool
) -> None:
    vehicle.ask("")
    vehicle.see(4)
    assert {(one.camera, one.state, one.cameras) for one in vehicle.pictures if one.jpeg} == {
        ("front", "recording", ("front",))
    }
    stamps_ns = [one.stamp_ns for one in vehicle.pictures if one.jpeg]
    assert len(stamps_ns) >= 2
    assert min(np.diff(stamps_ns)) >= 450_000_000
    shown = vehicle.pictures[-1]
    assert shown.coarse is is_coarse
    assert contrast(shown) < 20.0 if is_coarse else contrast(shown) > 100.0


def test_nothing_is_sent_that_was_not_asked_for(vehicle: Vehicle) -> None:
    vehicle.see(0)
    vehicle.requests.hear(Command(1, "command-1", "show_scene", "front"))
    vehicle.see(0)
    assert vehicle.pictures == []


def test_a_camera_without_pictures_says_so_each_second(vehicle: Vehicle) -> None:
    vehicle.ask("front")
    vehicle.see(2, sees=False)
    assert {(one.state, one.jpeg) for one in vehicle.pictures} == {("no_picture", b"")}


def test_a_camera_that_the_vehicle_lacks_is_answered_with_those_that_it_has(vehicle: Vehicle) -> None:
    vehicle.ask("roof")
    vehicle.see(1)
    (said,) = vehicle.pictures
    assert (said.camera, said.state, said.cameras) == ("roof", "unknown_camera", ("front",))


@pytest.mark.parametrize("vehicle", [("never", "none")], indirect=True)
def test_no_picture_leaves_a_vehicle_that_keeps_its_video(vehicle: Vehicle) -> None:
    vehicle.ask("front")
    vehicle.see(2)
    assert {(one.state, one.jpeg) for one in vehicle.pictures} == {("private", b"")}


def test_a_vehicle_without_cameras_and_one_whose_process_is_away_say_so() -> None:
    said: list[CameraPicture] = []
    CameraRequests(MONOTONIC, None, said.append).hear(Command(1, "a", "show_camera", "front"))
    CameraRequests(MONOTONIC, lambda _: False, said.append).hear(Command(1, "b", "show_camera", "front"))
    assert [(one.camera, one.state) for one in said] == [("front", "no_cameras"), ("front", "failed")]
    assert "away" in said[1].detail
