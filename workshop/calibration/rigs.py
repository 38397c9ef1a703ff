"""A vehicle's lidars on disk: their scans, the poses that are given, and the poses that were found."""

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from contract.geometry import Array
from contract.transforms import angles_of, inverse, transform_of
from workshop.calibration.calibrate import Calibration
from workshop.calibration.errors import CalibrationError
from workshop.clouds import bags
from workshop.clouds.errors import CloudFileError
from workshop.clouds.recordings import READERS, read_cloud

EXTRINSICS = "extrinsics.toml"
# As OpenCalib lays its samples out: poses by number, and which file has which number.
_OPENCALIB_POSES, _OPENCALIB_FILES = "initial_extrinsic.txt", "lidar_cloud_path.txt"
SCANS_MAX = 10


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """names, clouds (n, 3) in each lidar's frame, guesses T_reference_sensor; the reference is the first."""

    names: tuple[str, ...]
    clouds: tuple[Array, ...]
    guesses: tuple[Array | None, ...]


def load_rig(path: Path, reference: str | None = None, scans_max: int = SCANS_MAX) -> Rig:
    """The lidars of a folder (one file or one folder of scans for each) or of a bag (one topic for each).

    reference: a lidar's name; without it the one whose given pose is none, else the one with most points.
    CloudFileError or CalibrationError.
    """
    clouds = _of_bag(path, scans_max) if bags.is_bag(path) else _of_folder(path, scans_max)
    if len(clouds) < 2:
        raise CalibrationError(
            "too_few_lidars", f"{path} has {len(clouds)} lidars: {', '.join(clouds) or 'no scans'}"
        )
    given = read_extrinsics(path if path.is_dir() else path.parent)
    if reference is None:
        unmoved = [name for name, pose in given.items() if name in clouds and np.allclose(pose, np.eye(4))]
        reference = unmoved[0] if unmoved else max(clouds, key=lambda name: len(clouds[name]))
    if reference not in clouds:
        raise CalibrationError("too_few_lidars", f"no lidar {reference}; there are: {', '.join(clouds)}")
    names = (reference, *(name for name in clouds if name != reference))
    back = inverse(given[reference]) if reference in given else None
    guesses = tuple(back @ given[name] if back is not None and name in given else None for name in names)
    return Rig(names, tuple(clouds[name] for name in names), guesses)


def _of_folder(path: Path, scans_max: int) -> dict[str, Array]:
    if not path.is_dir():
        raise CloudFileError(path, "is no folder and no bag")
    clouds: dict[str, Array] = {}
    for child in sorted(path.iterdir()):
        if child.suffix.lower() in READERS:
            clouds[child.stem] = read_cloud(child).points_sensor.astype(np.float64)
        elif child.is_dir():
            files = sorted(file for file in child.iterdir() if file.suffix.lower() in READERS)
            if files:
                clouds[child.name] = _stacked(read_cloud(file).points_sensor for file in files[:scans_max])
    return clouds


def _of_bag(path: Path, scans_max: int) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for topic in bags.topics(path):
        if topic.has_scans:
            scans = islice(bags.scans(path, topic), scans_max)
            found[topic.name.strip("/").replace("/", "_")] = _stacked(scan.points_sensor for scan in scans)
    return found


def _stacked(scans: Iterable[np.ndarray]) -> Array:
    stacked = np.vstack([np.zeros((0, 3)), *scans])
    return stacked.astype(np.float64)


def read_extrinsics(folder: Path) -> dict[str, Array]:
    """Given poses by the lidar's name; empty where no file has any. CalibrationError for a wrong file."""
    try:
        if (folder / EXTRINSICS).exists():
            return _of_toml((folder / EXTRINSICS).read_text(encoding="utf-8"))
        if (folder / _OPENCALIB_POSES).exists() and (folder / _OPENCALIB_FILES).exists():
            return _of_opencalib(folder)
    except (OSError, UnicodeDecodeError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise CalibrationError(
            "bad_extrinsics", f"the given poses of {folder} cannot be read: {error}"
        ) from error
    return {}


def _of_toml(text: str) -> dict[str, Array]:
    return {
        name: _pose(
            [float(values[f"{key}_deg"]) for key in ("roll", "pitch", "yaw")],
            [float(values[f"{key}_m"]) for key in "xyz"],
        )
        for name, values in tomllib.loads(text)["lidars"].items()
    }


def _of_opencalib(folder: Path) -> dict[str, Array]:
    names = {}
    for number, file in re.findall(
        r"device_id:\s*(\d+)\s+path:\s*(\S+)", (folder / _OPENCALIB_FILES).read_text()
    ):
        names[number] = Path(file).stem
    poses = {}
    text = (folder / _OPENCALIB_POSES).read_text()
    for number, numbers in re.findall(r"device_id:\s*(\d+)\s*\n[^:\n]*:\s*([^\n]*)", text):
        values = [float(value) for value in numbers.split()]
        if len(values) != 6:
            raise ValueError(f"device {number} has {len(values)} values instead of 6")
        poses[names[number]] = _pose(values[:3], values[3:])
    return poses


def _pose(angles_deg: list[float], translation_m: list[float]) -> Array:
    roll, pitch, yaw = np.radians(angles_deg)
    pose = transform_of(roll, pitch, yaw, np.array(translation_m))
    if not np.isfinite(pose).all():
        raise ValueError("a pose has a value that is not finite")
    return pose


def extrinsics_toml(found: Calibration) -> str:
    """The poses as a TOML file that `load_rig` reads again: metres, degrees, standard deviations."""
    lines = [
        "# T_reference_sensor: points of the sensor in the frame of the reference. Roll, pitch and yaw about",
        "# the fixed axes x, y, z, in this order. std: deviations about and along the reference's axes.",
        f'reference = "{found.names[0]}"',
    ]
    for name, transform, stds in zip(found.names, found.transforms, found.stds, strict=True):
        x, y, z = transform[:3, 3]
        roll, pitch, yaw = np.degrees(angles_of(transform))
        turns, shifts = np.degrees(stds[:3]), stds[3:]
        lines += [
            "",
            f'[lidars."{name}"]',
            f"x_m = {x:.5f}\ny_m = {y:.5f}\nz_m = {z:.5f}",
            f"roll_deg = {roll:.4f}\npitch_deg = {pitch:.4f}\nyaw_deg = {yaw:.4f}",
            f"std_m = [{', '.join(f'{value:.5f}' for value in shifts)}]",
            f"std_deg = [{', '.join(f'{value:.4f}' for value in turns)}]",
        ]
    return "\n".join(lines) + "\n"
