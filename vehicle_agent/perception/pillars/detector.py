"""People, cyclists and vehicles in one scan, found by the trained network."""

from pathlib import Path

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from vehicle_agent.perception.pillars.decoding import DecodingParams, Detections, decoded, with_velocities
from vehicle_agent.perception.pillars.detector_file import (
    DEFAULT_DETECTOR,
    DetectorFileError,
    read_detector_file,
)
from vehicle_agent.perception.pillars.grid import pillars_of
from vehicle_agent.perception.pillars.shifts import shifts_of
from vehicle_agent.perception.pillars.standing_points import standing_points
from vehicle_agent.perception.pillars.sweeps import OlderTurn
from vehicle_agent.signals.objects import SeenObjects

Array32 = NDArray[np.float32]


class PillarDetector:
    """A detector's file, ready to run on the processor. The same scan gives the same objects."""

    def __init__(
        self,
        path: Path = DEFAULT_DETECTOR,
        own_m: tuple[float, float, float] = (-1.1, 3.75, 1.07),
        threads: int = 1,
        params: DecodingParams | None = None,
    ) -> None:
        """own_m: rear, front (x) and half width of what is the own body's, base frame.

        Raises DetectorFileError for a file that cannot be run.
        """
        model, self.record = read_detector_file(path)
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = threads
        # Errors only: warnings of the library are of no use to who drives.
        options.log_severity_level = 3
        try:
            self._session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
        except Exception as error:
            raise DetectorFileError(f"{path.name} cannot be run: {error}") from error
        self.grid, self._own_m = self.record.grid, own_m
        self._params = params or DecodingParams()

    def seen(
        self, points_base: Array32, intensities: Array32, stamp_ns: int, older: OlderTurn | None = None
    ) -> SeenObjects:
        """Objects of one turn of all lidars.

        points_base  (n, 3) m, base frame at stamp_ns; intensities (n,) 0 to 255
        older        the turn before, as `sweeps.step` gives it; without it velocities are NaN
        Raises ValueError for other shapes. A scan without returns has no objects.
        """
        turns = [(points_base, intensities)] + (
            [] if older is None else [(older.points_base, older.intensities)]
        )
        for points, values in turns:
            if points.ndim != 2 or points.shape[1] != 3 or values.shape != (len(points),):
                raise ValueError(
                    f"points are (n, 3) and intensities (n,), not {points.shape}, {values.shape}"
                )
        points = np.concatenate([turn[0] for turn in turns]).astype(np.float32, copy=False)
        values = np.concatenate([turn[1] for turn in turns]).astype(np.float32, copy=False)
        rows, heights = standing_points(points, self._own_m)
        kept = np.column_stack((points[rows, :2], heights, values[rows]))
        found = self.found(kept, rows >= len(points_base), None if older is None else older.older_s)
        boxes = found.boxes
        return SeenObjects(stamp_ns, found.kinds, found.scores, boxes[:, :3], boxes[:, 3:6], boxes[:, 6:8])

    def found(self, standing: Array32, is_older: NDArray[np.bool_], older_s: float | None) -> Detections:
        """Objects of returns (n, 4) above the ground: x, y, height, intensity, as `pillars_of` takes them.

        older_s  how much older the older turn is; None without one, and velocities are NaN
        """
        pillars = pillars_of(standing, is_older, self.grid)
        if not len(pillars.cells):
            return Detections(np.empty(0, dtype=np.int64), np.empty(0), np.empty((0, 8)))
        inputs = {"features": pillars.features, "cells": pillars.cells}
        heat, boxes = self._session.run(["heat", "boxes"], inputs)
        found = decoded(heat[0], boxes[0], self.grid, self._params)
        if older_s is None:
            return with_velocities(found, np.full((len(found.kinds), 2), np.nan))
        # The head has velocities, too; what the returns themselves show is closer (docs/vehicle/detector.md).
        return with_velocities(found, shifts_of(found.kinds, found.boxes, standing, is_older) / older_s)
