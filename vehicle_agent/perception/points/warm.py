"""Compiles the kernels of perception from points."""

import math

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.deskew import straightened
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.perception.tracking.below_beams import NearArea
from vehicle_agent.perception.tracking.tracker import ObjectTracker
from vehicle_agent.signals import VEHICLE
from vehicle_agent.signals.objects import SeenObjects


def warm_points() -> None:
    """Calls every kernel once: two people side by side on level ground, and a network's car."""
    straightened(np.zeros((1, 3), np.float32), np.zeros(1, np.float32), 1.0, 0.1)
    tracker = ObjectTracker(below_beams=NearArea(3.0, 3.5, 9.0, 0.8, 2.0))
    perception = PointPerception(PointGrid(2.4, 3.5, 0.85, 0.8), tracker=tracker)
    points = _two_people()
    state = perception.initial()
    intensities = np.zeros(len(points), np.float32)
    car = SeenObjects(
        0, np.array([VEHICLE]), np.array([0.9]), np.array([[10.0, 5.0, 0.1]]), np.array([[4.4, 1.8, 1.5]]),
        np.array([[2.0, 0.0]]),
    )  # fmt: skip
    for number in range(1, 4):
        stamp_ns = 100_000_000 * number
        _, _, state = perception.step(state, points, intensities, stamp_ns, Pose2(0.1 * number, 0.0, 0.0))
    _, _, state = perception.step(state, points, intensities, 400_000_000, Pose2(0.4, 0.0, 0.0), car)
    perception.step(state, points, intensities, 500_000_000, Pose2(0.5, 0.0, 0.0), car)


def _two_people() -> np.ndarray:
    """(n, 3) float32: a patch of road, and the fronts of two people 0.6 m apart at 8 m."""
    x, y = np.meshgrid(np.arange(4.0, 14.0, 0.2), np.arange(-5.0, 5.0, 0.2))
    road = np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size)))
    angle, z = np.meshgrid(np.linspace(0.5 * math.pi, 1.5 * math.pi, 12), np.arange(0.1, 1.75, 0.05))
    front = np.column_stack((8.0 + 0.2 * np.cos(angle.ravel()), 0.2 * np.sin(angle.ravel()), z.ravel()))
    aside = np.array([0.0, 0.3, 0.0])
    return np.vstack((road, front + aside, front - aside)).astype(np.float32)
