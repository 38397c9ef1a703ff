"""Compiles the bound's kernels into numba's cache, so that no proof's time has the compiler in it."""

import numpy as np

from campusloop.studies.bound.network import network_of
from campusloop.studies.bound.progress import Limits
from campusloop.studies.bound.proof import prove
from campusloop.studies.instances.instance import Instance

_LABELS = 5000


def warm_kernels() -> None:
    """Prove a bound of a few requests: each kernel is called with the very types that a proof gives it."""
    limits = Limits(events_max=5000, labels_max=_LABELS, enumeration_labels_max=_LABELS)
    for _ in prove(network_of(_three_of_a_kind()), limits):
        pass


def _three_of_a_kind() -> Instance:
    """Any two of three requests fit into one vehicle, all three do not: the relaxation has fractions."""
    angle = np.arange(3) * 2.0 * np.pi / 3.0
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Instance(
        name="three requests",
        vehicles=3,
        capacity=2,
        duration_max=100.0,
        ride_max=10.0,
        nodes=np.arange(7),
        xy=np.concatenate([[[30.0, 0.0]], ring, 3.0 * ring]),
        service=np.zeros(7),
        load=np.array([0, 1, 1, 1, -1, -1, -1]),
        early=np.concatenate([[0.0], np.full(3, 40.0), np.full(3, 40.0)]),
        late=np.concatenate([[200.0], np.full(3, 44.0), np.full(3, 60.0)]),
        pairs=np.array([[1, 4], [2, 5], [3, 6]]),
    )
