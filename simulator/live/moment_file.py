"""What moves in the world at one moment, for processes beside the simulator: a memory-mapped file.

One writer, any number of readers; none waits. A reader that meets a moment that is being written gets none,
and asks again.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contract.geometry import Array
from simulator.traffic.actors import Bodies
from vehicle_agent.device_feed import DeviceFeedError
from vehicle_agent.mapped_file import mapped

# More road users than that are left out, the last first.
BODIES_MAX = 4000
_VEHICLES_MAX = 1000
# A counter that is odd while a moment is written; stamp, vehicles, bodies.
_HEADER = struct.Struct("<qqqq")
_VALUES = 9
_BYTES = 64 + 8 * (3 * _VEHICLES_MAX + _VALUES * BODIES_MAX)


@dataclass(frozen=True, slots=True)
class Moment:
    """poses_map (v, 3) of the vehicles' rear axles, in their order; bodies: all road users, them too."""

    stamp_ns: int
    poses_map: Array
    bodies: Bodies


class MomentFile:
    """The newest moment of a world."""

    def __init__(self, path: Path, create: bool) -> None:
        """create: the simulator does. Raises DeviceFeedError if there is none to read."""
        try:
            self._map = mapped(path, _BYTES, create)
        except OSError as error:
            raise DeviceFeedError(
                f"no moments of a world at {path} ({error}); start the simulator first"
            ) from error
        self._counter = 0
        if create:
            _HEADER.pack_into(self._map, 0, 0, 0, 0, 0)

    def write(self, moment: Moment) -> None:
        """Raises ValueError for more than 1000 vehicles."""
        vehicles, count = len(moment.poses_map), min(len(moment.bodies.numbers), BODIES_MAX)
        if vehicles > _VEHICLES_MAX:
            raise ValueError(f"a moment has at most {_VEHICLES_MAX} vehicles, not {vehicles}")
        self._counter += 2
        _HEADER.pack_into(self._map, 0, self._counter - 1, moment.stamp_ns, vehicles, count)
        poses, values = self._arrays(vehicles, count)
        poses[:] = moment.poses_map
        bodies = moment.bodies
        values[:, 0], values[:, 1] = bodies.numbers[:count], bodies.kinds[:count]
        values[:, 2:5], values[:, 5:7] = bodies.poses_map[:count], bodies.velocities_map_mps[:count]
        values[:, 7:9] = bodies.sizes_m[:count]
        _HEADER.pack_into(self._map, 0, self._counter, moment.stamp_ns, vehicles, count)

    def read(self) -> Moment | None:
        """The newest moment; None before the first one, and while one is written."""
        counter, stamp_ns, vehicles, count = _HEADER.unpack_from(self._map, 0)
        if counter == 0 or counter % 2:
            return None
        poses, values = (array.copy() for array in self._arrays(vehicles, count))
        if _HEADER.unpack_from(self._map, 0)[0] != counter:
            return None
        bodies = Bodies(
            values[:, 0].astype(np.int64), values[:, 1].astype(np.int64), values[:, 2:5], values[:, 5:7],
            values[:, 7:9],
        )  # fmt: skip
        return Moment(stamp_ns, poses, bodies)

    def close(self) -> None:
        self._map.close()

    def _arrays(self, vehicles: int, count: int) -> tuple[Array, Array]:
        """((v, 3), (n, 9)) views of the file."""
        poses: Array = np.frombuffer(self._map, np.float64, 3 * vehicles, 64).reshape(vehicles, 3)
        values: Array = np.frombuffer(
            self._map, np.float64, _VALUES * count, 64 + 8 * 3 * _VEHICLES_MAX
        ).reshape(count, _VALUES)
        return poses, values


def moment_path(folder: Path) -> Path:
    """The file of a world's moments, beside the scan rings."""
    return folder / "moments"
