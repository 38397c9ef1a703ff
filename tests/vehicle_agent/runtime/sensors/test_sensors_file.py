"""sensors.toml places the sensors on the vehicle; what cannot work is refused with what to do."""

from pathlib import Path

import numpy as np
import pytest

from contract.transforms import apart, transform_of
from vehicle_agent.runtime.sensors.sensors_file import SensorsError, load_sensors

LIDAR = '[lidars.roof]\nlisten = "udp:2368"\nplace = { x_m = 2.0, y_m = 0.0, z_m = 2.1, yaw_deg = 90.0 }\n'
RECEIVER = (
    '[receivers.main]\nsource = "/dev/ttyACM0"\nbaud = 460800\nplace = { x_m = 1.0, y_m = 0.2, z_m = 2.0 }\n'
)
CORRECTIONS = '[corrections]\nurl = "http://caster.example/MOUNT"\nto = "main"\n'
# As `campusloop workshop calibrate` writes it.
EXTRINSICS = """# T_reference_sensor
reference = "roof"

[lidars."roof"]
x_m = 0.0
y_m = 0.0
z_m = 0.0
roll_deg = 0.0
pitch_deg = 0.0
yaw_deg = 0.0
std_m = [0.0, 0.0, 0.0]
std_deg = [0.0, 0.0, 0.0]

[lidars."left"]
x_m = 1.00000
y_m = 0.00000
z_m = -1.00000
roll_deg = 0.0000
pitch_deg = 10.0000
yaw_deg = 0.0000
std_m = [0.00100, 0.00100, 0.00100]
std_deg = [0.0100, 0.0100, 0.0100]
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "sensors.toml"
    path.write_text(text)
    return path


def test_a_vehicle_without_the_file_gets_its_values_from_other_processes(tmp_path: Path) -> None:
    assert load_sensors(tmp_path / "sensors.toml") is None


def test_sensors_are_placed_and_reached_as_the_file_says(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("pass\n")
    settings = load_sensors(write(tmp_path, LIDAR + RECEIVER + CORRECTIONS + 'password_file = "secret"\n'))
    assert settings is not None
    [roof] = settings.lidars
    assert (roof.name, roof.port, roof.is_required, roof.model) == ("roof", 2368, True, None)
    assert roof.T_base_sensor @ [1.0, 0.0, 0.0, 1.0] == pytest.approx([2.0, 1.0, 2.1, 1.0])
    address = settings.addresses["main"]
    assert (address.kind, address.path, address.baud) == ("device", "/dev/ttyACM0", 460_800)
    assert settings.caster is not None
    assert (settings.caster.mountpoint, settings.caster.password) == ("MOUNT", "pass")


def test_calibrated_lidars_are_placed_from_the_reference(tmp_path: Path) -> None:
    (tmp_path / "found.toml").write_text(EXTRINSICS)
    left = '[lidars.left]\nlisten = "udp:2369"\n'
    settings = load_sensors(write(tmp_path, 'extrinsics = "found.toml"\n' + LIDAR + left))
    assert settings is not None
    expected = transform_of(0.0, 0.0, 0.5 * np.pi, np.array([2.0, 0.0, 2.1])) @ transform_of(
        0.0, np.radians(10.0), 0.0, np.array([1.0, 0.0, -1.0])
    )
    assert sum(apart(settings.lidars[1].T_base_sensor, expected)) < 1e-12


def test_a_lidars_own_angles_are_read(tmp_path: Path) -> None:
    (tmp_path / "roof.csv").write_text(
        "id,el,az\n" + "\n".join(f"{n + 1},{15 - 2 * n},0.25" for n in range(16))
    )
    settings = load_sensors(write(tmp_path, LIDAR + 'model = "xt16"\nangles = "roof.csv"\n'))
    assert settings is not None
    model = settings.lidars[0].model
    assert model is not None
    assert np.degrees(model.azimuths_rad) == pytest.approx(np.full(16, 0.25))


SCANNER = '[people_scanner]\nsource = "tcp:10.0.0.9:2111"\n'


def test_planar_scanners_have_the_names_of_the_profile(tmp_path: Path) -> None:
    both = SCANNER + '[planar_scanner]\nsource = "tcp:10.0.0.9:2112"\n'
    settings = load_sensors(write(tmp_path, both))
    assert settings is not None
    assert {name: (one.host, one.port) for name, one in settings.scanners.items()} == {
        "people_scanner": ("10.0.0.9", 2111),
        "planar_scanner": ("10.0.0.9", 2112),
    }
    assert settings.lidars == ()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "it names no sensor"),
        (LIDAR.replace("udp:2368", "tcp:a:2368"), "give udp:PORT"),
        (LIDAR.replace("udp:2368", "udp:0"), "is none of /dev/NAME, tcp:HOST:PORT, udp:PORT"),
        (LIDAR.replace("2.1", "nan"), "not finite"),
        (LIDAR.replace("z_m = 2.1, ", ""), "z_m"),
        (LIDAR + 'model = "OS1"\n', "no model 'OS1'; there are: VLP-16"),
        (LIDAR + 'angles = "roof.csv"\n', "angles need a model"),
        (LIDAR + 'model = "XT16"\nangles = "roof.csv"\n', "roof.csv"),
        (LIDAR + LIDAR.replace("roof", "left"), "same UDP port"),
        ('[lidars.left]\nlisten = "udp:2369"\n', "lidar left has no place"),
        ('extrinsics = "none.toml"\n' + LIDAR, "none.toml"),
        (RECEIVER.replace("460800", "12345"), "main: 12345 baud; there are: 9600"),
        (RECEIVER.replace("/dev/ttyACM0", "com3"), "'com3' is none of"),
        (RECEIVER + CORRECTIONS.replace("main", "other"), "'other', which is no receiver"),
        (RECEIVER.replace("/dev/ttyACM0", "udp:5000") + CORRECTIONS, "can be written to"),
        (RECEIVER + CORRECTIONS.replace("/MOUNT", ""), "http"),
        (RECEIVER + CORRECTIONS.replace("caster", "me:secret@caster"), "password_file"),
        (RECEIVER + RECEIVER.replace("receivers", "inertial"), "have one name"),
        (
            SCANNER.replace("tcp:10.0.0.9:2111", "udp:2111"),
            "people_scanner: a planar scanner is reached by tcp",
        ),
        (SCANNER.replace("tcp:10.0.0.9:2111", "10.0.0.9"), "people_scanner: '10.0.0.9' is none of"),
        (SCANNER + SCANNER.replace("people", "planar"), "have the same address"),
        (LIDAR + "colour = 1\n", "colour"),
        ("[lidars\n", "line 1"),
    ],
)
def test_what_cannot_work_is_refused(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(SensorsError, match=says) as refused:
        load_sensors(write(tmp_path, text))
    assert str(refused.value).startswith(str(tmp_path / "sensors.toml"))


def test_a_file_that_no_calibration_wrote_is_refused(tmp_path: Path) -> None:
    (tmp_path / "found.toml").write_text("[lidars]\nroof = 3\n")
    with pytest.raises(SensorsError, match="no file of `workshop calibrate`"):
        load_sensors(write(tmp_path, 'extrinsics = "found.toml"\n' + LIDAR))
    (tmp_path / "found.toml").write_text(EXTRINSICS.replace('reference = "roof"', 'reference = "left"'))
    with pytest.raises(SensorsError, match="reference, left, needs a place here"):
        load_sensors(write(tmp_path, 'extrinsics = "found.toml"\n' + LIDAR))
