"""Compiles the kernel of the calibration by motion."""

import numpy as np

from workshop.motion_calibration.integration import integrate


def warm_kernels() -> None:
    """Calls it once: a unit at rest."""
    stamps_s = np.linspace(0.0, 1.0, 11)
    forces = np.tile([0.0, 0.0, 9.81], (11, 1))
    integrate(stamps_s, np.zeros((11, 3)), forces, stamps_s)
