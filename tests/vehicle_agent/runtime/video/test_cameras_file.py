"""cameras.toml: what cannot be meant is refused with the camera's name."""

from pathlib import Path

import pytest

from vehicle_agent.perception.camera.lens import Lens
from vehicle_agent.runtime.video.cameras_file import CamerasError, load_cameras

RING = Path("/dev/shm/scans")


def loaded(folder: Path, text: str) -> object:
    path = folder / "cameras.toml"
    path.write_text(text)
    return load_cameras(path, RING)


def test_without_the_file_nothing_is_recorded(tmp_path: Path) -> None:
    assert load_cameras(tmp_path / "cameras.toml", RING) is None


def test_sources_are_found(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("a:b@c\n")
    text = """
        keep_gib = 5
        [cameras.front]
        source = "/dev/video0"
        [cameras.left]
        source = "rtsp://10.0.0.7/main"
        user = "shuttle"
        password_file = "secret"
        [cameras.rear]
        source = "ring"
        [cameras.right]
        source = "right.avi"
        """
    (tmp_path / "cameras.toml").write_text(text)
    settings = load_cameras(tmp_path / "cameras.toml", RING)
    assert settings is not None
    assert settings.keep_gib == 5.0
    assert {one.name: one.address for one in settings.cameras} == {
        "front": "/dev/video0",
        "left": "rtsp://shuttle:a%3Ab%40c@10.0.0.7/main",
        "rear": "/dev/shm/scans-rear.pictures",
        "right": str(tmp_path / "right.avi"),
    }


def test_the_camera_for_people_has_a_lens_and_is_not_recorded(tmp_path: Path) -> None:
    lens = Lens(640, 480, 512.0, 510.0, 324.0, 236.0, (-0.28, 0.09, 0.0, 0.0, 0.0))
    (tmp_path / "front.toml").write_text(lens.toml())
    (tmp_path / "cameras.toml").write_text(
        '[people_camera]\nsource = "/dev/video2"\nheight_px = 720\ncalibration = "front.toml"\n'
    )
    settings = load_cameras(tmp_path / "cameras.toml", RING)
    assert settings is not None
    assert settings.cameras == ()
    assert settings.people is not None
    assert (settings.people.address, settings.people.lens) == ("/dev/video2", lens)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "cameras"),
        ('[people_camera]\nsource = "ring"', "another process writes into its ring"),
        ('[people_camera]\nsource = "rtsp://me:secret@10.0.0.7/"', "password_file"),
        ('[people_camera]\nsource = "/dev/video0"\ncalibration = "none.toml"', "none.toml"),
        ('[people_camera]\nsource = "/dev/video0"\n[cameras.a]\nsource = "/dev/video0"', "same source"),
        ("[cameras]", "0 cameras"),
        ('[cameras.Front]\nsource = "ring"', "'Front'"),
        ('[cameras.front]\nsource = "http://10.0.0.7/"', "rtsp"),
        ('[cameras.front]\nsource = "rtsp://me:secret@10.0.0.7/"', "password_file"),
        ('[cameras.front]\nsource = "ring"\nwidth_px = 641', "width_px"),
        ('[cameras.people]\nsource = "ring"', "choose another name"),
        ('[cameras.front]\nsource = "ring"\nrate_hz = nan', "rate_hz"),
        ('[cameras.front]\nsource = "/dev/video0"\n[cameras.rear]\nsource = "/dev/video0"', "same source"),
        ('[cameras.front]\nsource = "rtsp://h/"\nuser = "u"\npassword_file = "none"', "none"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(CamerasError, match=r"cameras\.toml") as refused:
        loaded(tmp_path, text)
    assert said in str(refused.value)
    assert "secret" not in str(refused.value) or "password_file" in str(refused.value)
