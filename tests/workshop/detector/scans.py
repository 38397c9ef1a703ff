"""Labeled scans made by hand: bodies with returns on all their sides, which move at their velocity."""

import numpy as np

from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE
from workshop.detector.labeled_scans import LabeledScan

SIZES_M = {PEDESTRIAN: (0.5, 0.5, 1.7), CYCLIST: (1.75, 0.6, 1.7), VEHICLE: (4.4, 1.8, 1.5)}
OLDER_S = 0.2


def a_scan(seed: int, users: int = 6) -> LabeledScan:
    """Road users 7 m apart."""
    rng = np.random.default_rng(seed)
    places = [(x, y) for x in (-7.0, 7.0, 14.0) for y in (-10.0, -3.0, 4.0, 11.0)]
    kinds, boxes, points, older = [], [], [], []
    for number in rng.permutation(len(places))[:users]:
        kind = int(rng.choice([PEDESTRIAN, CYCLIST, VEHICLE]))
        yaw, speed = rng.uniform(-3.0, 3.0), float(rng.choice([0.0, 2.0]))
        velocity = speed * np.array([np.cos(yaw), np.sin(yaw)])
        length, width, height = SIZES_M[kind]
        box = np.array([*places[number], yaw, length, width, height, *velocity])
        for is_older in (False, True):
            around = rng.uniform(-0.5, 0.5, (60, 2)) * (length, width)
            turned = around @ np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
            middle = box[:2] - is_older * OLDER_S * velocity
            rows = np.column_stack((turned + middle, rng.uniform(0.2, height, 60), rng.uniform(5, 60, 60)))
            points.append(rows)
            older.append(np.full(60, is_older))
        kinds.append(kind)
        boxes.append(box)
    return LabeledScan(
        np.concatenate(points).astype(np.float32), np.concatenate(older), OLDER_S,
        np.array(kinds, dtype=np.int64), np.array(boxes), np.full(users, 60, dtype=np.int64),
    )  # fmt: skip
