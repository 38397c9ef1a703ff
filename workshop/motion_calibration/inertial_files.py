"""An inertial unit's samples on disk: a table (CSV), or a topic of a bag."""

import csv
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from workshop.calibration.errors import CalibrationError
from workshop.clouds import bags
from workshop.clouds.errors import CloudFileError
from workshop.motion_calibration.drive import InertialDrive, inertial_drive

IMU_TYPE = "sensor_msgs/msg/Imu"
COLUMNS = (
    "stamp_s", "rate_x_radps", "rate_y_radps", "rate_z_radps", "force_x_mps2", "force_y_mps2", "force_z_mps2",
)  # fmt: skip


def read_inertial(path: Path, topic: str | None = None) -> InertialDrive:
    """The samples of a CSV file with `COLUMNS`, or of a bag's topic; CalibrationError or CloudFileError.

    topic: of a bag; without it the one topic of Imu messages that it has. The force contains gravity.
    """
    if bags.is_bag(path):
        return _of_bag(path, topic)
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or [])]
            if missing:
                raise CalibrationError("bad_samples", f"{path} has no column {', '.join(missing)}")
            stamps: list[int] = []
            rows: list[list[float]] = []
            for row in reader:
                # A date in seconds has more digits than a float.
                stamps.append(int(Decimal(row[COLUMNS[0]]) * 1_000_000_000))
                rows.append([float(row[name]) for name in COLUMNS[1:]])
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise CalibrationError("bad_samples", f"{path} cannot be read: {error}") from error
    except (TypeError, ValueError, InvalidOperation, OverflowError) as error:
        raise CalibrationError(
            "bad_samples", f"{path}, line {reader.line_num}: a value is no number ({error})"
        ) from error
    return _drive(stamps, rows)


def _of_bag(path: Path, topic: str | None) -> InertialDrive:
    known = [one.name for one in bags.topics(path) if one.kind == IMU_TYPE]
    chosen = topic or (known[0] if len(known) == 1 else None)
    if chosen not in known:
        asked = f"no topic {topic} of {IMU_TYPE}" if topic else f"{len(known)} topics of {IMU_TYPE}, name one"
        raise CloudFileError(path, f"{asked}; there are: {', '.join(known) or 'none'}")
    stamps: list[int] = []
    rows: list[list[float]] = []
    for item in bags.messages(path, (chosen,)):
        rates, forces = item.message.angular_velocity, item.message.linear_acceleration
        stamps.append(bags.stamp_of(item.message.header.stamp) or item.recorded_ns)
        rows.append([rates.x, rates.y, rates.z, forces.x, forces.y, forces.z])
    return _drive(stamps, rows)


def _drive(stamps: list[int], rows: list[list[float]]) -> InertialDrive:
    table = np.array(rows, dtype=np.float64).reshape(len(rows), 6)
    return inertial_drive(np.array(stamps, dtype=np.int64), table[:, :3], table[:, 3:])
