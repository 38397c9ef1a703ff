"""Compiles the kernels of lidar mapping."""

import numpy as np

from contract.roads.model import Origin
from vehicle_agent.signals.point_cloud import point_cloud
from workshop.cloud_mapping.descriptors import descriptor, distance_of
from workshop.cloud_mapping.gnss_fixes import Fixes
from workshop.cloud_mapping.mapping import CloudMappingParams, NoProgress, map_scans
from workshop.cloud_mapping.submaps import SubmapParams, registered, submap


def warm_kernels() -> None:
    """Calls every kernel once: a walk of a few metres through a room, with fixes."""
    rng = np.random.default_rng(1)
    walls = rng.uniform(-8.0, 8.0, (6_000, 3))
    walls[np.arange(6_000), rng.integers(0, 3, 6_000)] = -2.0
    offsets_ns = np.linspace(0, 90_000_000, len(walls))
    scans = [
        point_cloud(100_000_000 * number, walls - np.array([0.25 * number, 0.0, 0.0]), offsets_ns=offsets_ns)
        for number in range(12)
    ]
    fixes = Fixes(
        Origin(31.0, 121.0),
        100_000_000 * np.arange(12, dtype=np.int64),
        np.column_stack((0.25 * np.arange(12), np.zeros(12), np.zeros(12))),
        np.tile([0.02, 0.02, np.inf], (12, 1)),
        0,
    )
    map_scans(scans, len(scans), fixes, CloudMappingParams(), NoProgress())
    params = SubmapParams()
    here = submap([walls.astype(np.float32)], np.eye(4)[None], 0, params)
    registered(here, here, np.eye(4), params)
    grid = descriptor(walls, -2.0)
    distance_of(grid, grid)
