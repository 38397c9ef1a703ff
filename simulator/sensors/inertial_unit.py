"""A strapdown inertial unit: specific force and turn rates about three axes along a trajectory in space."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.lidars.scanner import Trajectory
from simulator.vehicle.plant import GRAVITY_MPS2

# Half of the time over which the trajectory is differentiated.
_HALF_NS = 2_500_000


@dataclass(frozen=True, slots=True)
class InertialNoise:
    """Standard deviations of a MEMS unit; biases, scales and misalignment are drawn once for each unit.

    *_walk   growth of a bias per square root of a second
    *_scale  error of an axis' scale; cross_axis_rad: of its direction
    """

    force_std_mps2: float = 0.03
    force_bias_std_mps2: float = 0.02
    force_walk_mps2: float = 2e-4
    force_scale_std: float = 1e-3
    rate_std_radps: float = 0.002
    rate_bias_std_radps: float = 5e-4
    rate_walk_radps: float = 1e-5
    rate_scale_std: float = 1e-3
    cross_axis_rad_std: float = 5e-4


@dataclass(frozen=True, slots=True, eq=False)
class InertialSamples:
    """stamps_ns (n,); specific_force_mps2 (n, 3) and rates_radps (n, 3) in the unit's frame.

    At rest on level ground the specific force is (0, 0, 9.81).
    """

    stamps_ns: NDArray[np.int64]
    specific_force_mps2: Array
    rates_radps: Array


class InertialUnit:
    """One unit, at T_base_unit (4, 4) on its vehicle; the same generator state gives the same samples."""

    def __init__(self, T_base_unit: Array, noise: InertialNoise, rng: np.random.Generator) -> None:
        self._T_base_unit, self._noise, self._rng = T_base_unit, noise, rng
        deviates = rng.standard_normal((6, 3))
        self._force_bias = noise.force_bias_std_mps2 * deviates[0]
        self._rate_bias = noise.rate_bias_std_radps * deviates[1]
        self._force_axes = _axes(noise.force_scale_std * deviates[2], noise.cross_axis_rad_std * deviates[3])
        self._rate_axes = _axes(noise.rate_scale_std * deviates[4], noise.cross_axis_rad_std * deviates[5])
        self._last_ns: int | None = None

    def samples(self, trajectory: Trajectory, stamps_ns: NDArray[np.int64]) -> InertialSamples:
        """The readings at rising times; call it with later times only, since biases walk on.

        trajectory  T_map_base (n, 4, 4), asked 2.5 ms before and after each time, too; z of the map is up
        """
        noise, n = self._noise, len(stamps_ns)
        force, rates = self._true(trajectory, stamps_ns)
        white = self._rng.standard_normal((4, n, 3))
        last_ns = int(stamps_ns[0]) if self._last_ns is None else self._last_ns
        steps = np.sqrt(np.diff(stamps_ns, prepend=last_ns) * 1e-9)[:, None]
        force_bias = self._force_bias + np.cumsum(noise.force_walk_mps2 * steps * white[0], axis=0)
        rate_bias = self._rate_bias + np.cumsum(noise.rate_walk_radps * steps * white[1], axis=0)
        self._force_bias, self._rate_bias, self._last_ns = force_bias[-1], rate_bias[-1], int(stamps_ns[-1])
        return InertialSamples(
            stamps_ns,
            force @ self._force_axes.T + force_bias + noise.force_std_mps2 * white[2],
            rates @ self._rate_axes.T + rate_bias + noise.rate_std_radps * white[3],
        )

    def _true(self, trajectory: Trajectory, stamps_ns: NDArray[np.int64]) -> tuple[Array, Array]:
        before, now, after = (
            np.asarray(trajectory(stamps_ns + shift)) @ self._T_base_unit
            for shift in (-_HALF_NS, 0, _HALF_NS)
        )
        half_s = _HALF_NS * 1e-9
        accel = (after[:, :3, 3] - 2.0 * now[:, :3, 3] + before[:, :3, 3]) / half_s**2
        up = accel + np.array([0.0, 0.0, GRAVITY_MPS2])
        back = now[:, :3, :3].transpose(0, 2, 1)
        force = np.einsum("nij,nj->ni", back, up)
        turned = before[:, :3, :3].transpose(0, 2, 1) @ after[:, :3, :3]
        return force, _rotation_vectors(turned) / (2.0 * half_s)


def _axes(scales: Array, cross: Array) -> Array:
    """(3, 3) what the axes make of a vector: scale errors on the diagonal, misalignment beside it."""
    x, y, z = cross
    axes: Array = np.diag(1.0 + scales) + np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return axes


def _rotation_vectors(rotations: Array) -> Array:
    """(n, 3) rad of rotations (n, 3, 3) far from half a turn."""
    twice_sine = np.stack(
        (
            rotations[:, 2, 1] - rotations[:, 1, 2],
            rotations[:, 0, 2] - rotations[:, 2, 0],
            rotations[:, 1, 0] - rotations[:, 0, 1],
        ),
        axis=1,
    )
    sine = np.minimum(0.5 * np.linalg.norm(twice_sine, axis=1), 1.0)
    angle = np.arcsin(sine)
    scale = np.where(sine > 1e-9, angle / np.maximum(sine, 1e-12), 1.0)
    vectors: Array = 0.5 * scale[:, None] * twice_sine
    return vectors
