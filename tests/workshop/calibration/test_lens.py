"""A lens is measured from pictures of a chessboard, and pictures are freed of it."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from tests.workshop.calibration.chessboards import COLUMNS, LENS, ROWS, write_pictures
from vehicle_agent.perception.camera.lens import Lens, LensError, Rectification, load_lens
from vehicle_agent.signals.pictures import pinhole_matrix

pytest.importorskip("cv2", reason="needs the extra `camera`")


def run(*arguments: str) -> tuple[int, str]:
    ran = CliRunner().invoke(app_of(["workshop"]), ["workshop", "calibrate-camera", *arguments])
    return ran.exit_code, ran.output.replace("\n", " ")


def test_the_lens_of_a_camera_is_found_from_its_pictures(tmp_path: Path) -> None:
    write_pictures(tmp_path, 14)
    out = tmp_path / "front.toml"
    code, said = run(str(tmp_path), "--out", str(out))
    assert code == 0, said
    lens = load_lens(out)
    assert (lens.width_px, lens.height_px) == (640, 480)
    assert (lens.fx_px, lens.fy_px) == (pytest.approx(512.0, rel=0.01), pytest.approx(510.0, rel=0.01))
    assert (lens.cx_px, lens.cy_px) == (pytest.approx(324.0, abs=4.0), pytest.approx(236.0, abs=4.0))
    assert lens.rms_px < 0.3
    code, said = run(str(tmp_path), "--out", str(tmp_path / "nowhere" / "front.toml"))
    assert (code, "No such file" in said) == (2, True)
    # What matters: where a ray is seen. Half-way to the corners it is within a pixel.
    cv2 = pytest.importorskip("cv2")
    rays = np.array([[x, y, 1.0] for x in (-0.35, 0.0, 0.35) for y in (-0.25, 0.25)])
    seen = [
        cv2.projectPoints(rays, np.zeros(3), np.zeros(3), one.matrix(), np.array(one.distortion))[0]
        for one in (lens, LENS)
    ]
    assert np.abs(seen[0] - seen[1]).max() < 1.0
    code, said = run(str(tmp_path), "--out", str(out))
    assert code == 2
    assert "is there already" in said


def test_pictures_from_which_no_lens_can_be_found_are_refused(tmp_path: Path) -> None:
    out = str(tmp_path / "lens.toml")
    code, said = run(str(tmp_path), "--out", out)
    assert (code, "has no pictures" in said) == (2, True)
    assert run(str(tmp_path), "--board", "nine", "--out", out)[0] == 2
    write_pictures(tmp_path, 5)
    code, said = run(str(tmp_path), "--out", out)
    assert code == 2
    assert f"the board of {COLUMNS} x {ROWS} inner corners is whole in 5 of 5 pictures" in said
    (tmp_path / "05.png").write_bytes(b"no picture")
    code, said = run(str(tmp_path), "--out", out)
    assert (code, "05.png is no picture" in said) == (2, True)
    assert not Path(out).exists()


def test_a_board_that_was_only_held_into_the_middle_is_refused(tmp_path: Path) -> None:
    write_pictures(tmp_path, 12, spread=0.0)
    code, said = run(str(tmp_path), "--out", str(tmp_path / "lens.toml"))
    assert code == 2
    assert "hold it into all corners too" in said


def test_pictures_freed_of_their_lens_are_those_of_the_profiles_pinhole() -> None:
    """A dot for each ray: after the lens is taken out it lies where the pinhole has it."""
    cv2 = pytest.importorskip("cv2")
    K = pinhole_matrix(640, 480, np.radians(50.0))
    rectification = Rectification(LENS, K, 640, 480)
    assert rectification.seen_share() == pytest.approx(1.0, abs=0.02)
    for ray in ([0.0, 0.0, 1.0], [0.35, 0.2, 1.0], [-0.35, -0.25, 1.0]):
        at = cv2.projectPoints(
            np.array([ray]), np.zeros(3), np.zeros(3), LENS.matrix(), np.array(LENS.distortion)
        )[0].ravel()
        picture = np.zeros((480, 640, 3), dtype=np.uint8)
        cv2.circle(picture, (round(at[0]), round(at[1])), 3, (255, 255, 255), -1)
        rows, columns = np.nonzero(rectification.pixels(picture)[:, :, 0] > 128)
        place = K @ ray
        assert (columns.mean(), rows.mean()) == pytest.approx(place[:2] / place[2], abs=1.0)
    with pytest.raises(ValueError, match="320 x 240 px, and the lens was measured with 640 x 480"):
        rectification.pixels(np.zeros((240, 320, 3), dtype=np.uint8))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"fx_px": 0.0}, "above 0"),
        ({"fx_px": float("nan")}, "finite"),
        ({"fx_px": 20.0}, "too wide"),
        ({"cx_px": 900.0}, "outside the picture"),
        ({"distortion": (0.1,)}, "4, 5 or 8"),
        ({"width_px": 1}, "width_px"),
    ],
)
def test_a_lens_that_no_camera_has_is_refused(tmp_path: Path, change: dict[str, object], says: str) -> None:
    values = {name: getattr(LENS, name) for name in Lens.__struct_fields__} | change
    lines = [
        f"{name} = {list(value) if isinstance(value, tuple) else value}" for name, value in values.items()
    ]
    (tmp_path / "lens.toml").write_text("\n".join(lines))
    with pytest.raises(LensError, match=says):
        load_lens(tmp_path / "lens.toml")
    with pytest.raises(LensError, match=r"none\.toml"):
        load_lens(tmp_path / "none.toml")
