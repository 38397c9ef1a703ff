"""Occupancy maps on disk: the image and the YAML file that ROS's map_server and nav2 read too.

The image is a binary PGM, its first row the greatest y: 0 occupied, 254 free, 205 unknown. The YAML file has
map_server's keys and two of ours, `campusloop_format` and `campusloop_map_hash`, which map_server ignores.
"""

import json
import math
import re
from pathlib import Path

import numpy as np

from contract.occupancy.occupancy_map import FORMAT, FREE, OCCUPIED, UNKNOWN, Cells, OccupancyMap

_OCCUPIED_GREY, _UNKNOWN_GREY, _FREE_GREY = 0, 205, 254
_OCCUPIED_MIN, _FREE_MAX = 0.65, 0.196
_PGM_HEADER = re.compile(rb"P5\s+(?:#[^\n]*\n\s*)*(\d+)\s+(?:#[^\n]*\n\s*)*(\d+)\s+(?:#[^\n]*\n\s*)*(\d+)\s")
_CELLS_MAX = 400_000_000


class MapFileError(ValueError):
    """The files are no occupancy map; the message is one sentence for the person who named them."""


def write_map(occupancy: OccupancyMap, yaml_path: Path) -> None:
    """Write the YAML file and, beside it, the image of the same name."""
    image_path = yaml_path.with_suffix(".pgm")
    rows, columns = occupancy.cells.shape
    greys = np.full((rows, columns), _UNKNOWN_GREY, dtype=np.uint8)
    greys[occupancy.cells == FREE] = _FREE_GREY
    greys[occupancy.cells == OCCUPIED] = _OCCUPIED_GREY
    image_path.write_bytes(b"P5\n%d %d\n255\n" % (columns, rows) + np.flipud(greys).tobytes())
    yaml_path.write_text(
        f"image: {json.dumps(image_path.name)}\n"
        "mode: trinary\n"
        f"resolution: {occupancy.cell_m!r}\n"
        f"origin: [{occupancy.origin_x_m!r}, {occupancy.origin_y_m!r}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {_OCCUPIED_MIN}\n"
        f"free_thresh: {_FREE_MAX}\n"
        f"campusloop_format: {FORMAT}\n"
        f"campusloop_map_hash: {occupancy.map_hash}\n",
        encoding="utf-8",
    )


def read_map(yaml_path: Path) -> OccupancyMap:
    """The map, ours or map_server's. Raises MapFileError where it is none, or where ours has been changed."""
    values = _yaml_values(yaml_path)
    try:
        cell_m = float(values["resolution"])
        x_m, y_m, yaw_rad = (float(part) for part in values["origin"].strip("[]").split(","))
        occupied_min, free_max = float(values["occupied_thresh"]), float(values["free_thresh"])
        is_negated = int(values.get("negate", "0")) != 0
        image_path = yaml_path.parent / values["image"].strip("\"'")
    except (KeyError, ValueError) as error:
        raise MapFileError(f"{yaml_path} is no occupancy map: {error} is missing or no number.") from error
    if not (cell_m > 0.0 and all(map(math.isfinite, (cell_m, x_m, y_m)))):
        raise MapFileError(f"{yaml_path} has no usable resolution or origin.")
    if yaw_rad != 0.0:
        raise MapFileError(f"{yaml_path} is a turned map, which is not supported: its origin needs yaw 0.")
    if int(values.get("campusloop_format", str(FORMAT))) != FORMAT:
        raise MapFileError(f"{yaml_path} was written by another version of Campusloop.")
    greys = np.flipud(_pgm(image_path)).astype(np.float64)
    occupied = greys / 255.0 if is_negated else (255.0 - greys) / 255.0
    cells: Cells = np.full(greys.shape, UNKNOWN, dtype=np.uint8)
    cells[occupied > occupied_min] = OCCUPIED
    cells[occupied < free_max] = FREE
    occupancy = OccupancyMap(cells, cell_m, x_m, y_m)
    stated = values.get("campusloop_map_hash", occupancy.map_hash)
    if stated != occupancy.map_hash:
        raise MapFileError(f"{yaml_path} and its image have been changed since they were written.")
    return occupancy


def _yaml_values(path: Path) -> dict[str, str]:
    """The file's keys: map_server's files are flat, with one `key: value` a line."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise MapFileError(f"{path} cannot be read: {error}.") from error
    values = {}
    for line in text.splitlines():
        key, colon, value = line.partition(":")
        if colon and not key.lstrip().startswith("#"):
            values[key.strip()] = value.partition(" #")[0].strip()
    return values


def _pgm(path: Path) -> Cells:
    """(rows, columns) grey values, the first row on top."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MapFileError(f"{path} cannot be read: {error.strerror or error}.") from error
    header = _PGM_HEADER.match(data)
    if header is None:
        raise MapFileError(f"{path} is no binary PGM image.")
    columns, rows, greatest = (int(group) for group in header.groups())
    size = rows * columns
    if greatest != 255 or not 0 < size <= _CELLS_MAX or len(data) - header.end() < size:
        raise MapFileError(f"{path} is no whole PGM image of 8 bits.")
    return np.frombuffer(data, dtype=np.uint8, count=size, offset=header.end()).reshape(rows, columns)
