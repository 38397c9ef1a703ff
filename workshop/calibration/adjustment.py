"""Poses of lidars and the planes of patches, adjusted together.

Every patch is a small plane that two or more lidars see. All poses and all planes are unknown; the sum of the
squared distances of all points from their patch's plane is least (plane adjustment: Liu and Zhang, "BALM",
2021; of each patch and lidar the second moments are all that is needed).
"""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from contract.transforms import moved, rotation_of
from workshop.calibration.planes import axes_of, fit_plane


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """points[k]: (n, 3) of lidar k on this patch, in its own frame; empty where it sees none."""

    points: tuple[Array, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Adjustment:
    """What came out.

    transforms   (k, 4, 4) T_reference_sensor
    planes       (p, 4) normal and offset of each patch, reference frame
    deviations_m (k,) standard deviation of each lidar's points from the planes (median absolute)
    stds         (k, 6) standard deviations of the poses: rotation (rad) and translation (m) about and along
                 the reference's axes; the reference's own are 0
    """

    transforms: Array
    planes: Array
    deviations_m: Array
    stds: Array


_ROUNDS = 5
_STEPS = 3
_MAD = 1.4826
_DEVIATION_M_MIN = 0.003
# Where Cauchy's weight is half; 95 % efficient on normal errors.
_CAUCHY = 2.3849


@dataclass(frozen=True, slots=True)
class Prior:
    """How well the poses are known before: standard deviations of the rotation and the translation.

    Where the patches say little (along a street), the registration of all points, poles and trees among them,
    says more.
    """

    rotation_rad: float = 0.005
    translation_m: float = 0.03


def adjust(patches: list[Patch], transforms: Array, prior: Prior | None = None) -> Adjustment:
    """The poses and planes of least squares, from poses (k, 4, 4) that are nearly right; lidar 0 stays.

    prior: of these poses. `stds` are those of the patches alone, without it. Points are weighted by their
    lidar's deviation and by Cauchy's function, which the edges of patches and passers-by need. numpy's
    LinAlgError if the patches do not determine the poses.
    """
    before, transforms = transforms, transforms.copy()
    planes = np.array([_start_plane(patch, transforms) for patch in patches])
    deviations = _deviations(patches, transforms, planes)
    moments, reduced = np.zeros(0), np.zeros(0)
    for _ in range(_ROUNDS):
        moments = _moments(patches, transforms, planes, deviations)
        for _ in range(_STEPS):
            reduced = _step(moments, transforms, planes, before, prior)
        deviations = _deviations(patches, transforms, planes)
    stds = np.zeros((len(transforms), 6))
    stds[1:] = _stds(moments, transforms, planes, reduced).reshape(-1, 6)
    return Adjustment(transforms, planes, deviations, stds)


def distances_of(patch: Patch, transforms: Array, plane: Array) -> list[Array]:
    """Of each lidar the signed distances (n,) of its points from the plane (4,)."""
    return [moved(t, p) @ plane[:3] + plane[3] for t, p in zip(transforms, patch.points, strict=True)]


def _start_plane(patch: Patch, transforms: Array) -> Array:
    together = np.vstack([moved(t, p) for t, p in zip(transforms, patch.points, strict=True)])
    normal, offset, _ = fit_plane(together)
    return np.append(normal, offset)


def _deviations(patches: list[Patch], transforms: Array, planes: Array) -> Array:
    """(k,) of each lidar's points; a lidar without points has the least, it does not matter."""
    of_lidars: list[list[Array]] = [[] for _ in transforms]
    for patch, plane in zip(patches, planes, strict=True):
        for found, distances in zip(of_lidars, distances_of(patch, transforms, plane), strict=True):
            found.append(distances)
    spreads = [_MAD * float(np.median(np.abs(np.concatenate([*found, [0.0]])))) for found in of_lidars]
    deviations: Array = np.maximum(spreads, _DEVIATION_M_MIN)
    return deviations


def _moments(patches: list[Patch], transforms: Array, planes: Array, deviations: Array) -> Array:
    """(patches, lidars, 4, 4) weighted second moments of homogeneous points, each in its lidar's frame."""
    moments = np.zeros((len(patches), len(transforms), 4, 4))
    for number, (patch, plane) in enumerate(zip(patches, planes, strict=True)):
        for lidar, distances in enumerate(distances_of(patch, transforms, plane)):
            scaled = distances / (_CAUCHY * deviations[lidar])
            weights = 1.0 / ((1.0 + scaled**2) * deviations[lidar] ** 2)
            homogeneous = np.column_stack((patch.points[lidar], np.ones(len(distances))))
            moments[number, lidar] = (homogeneous * weights[:, None]).T @ homogeneous
    return moments


def _step(moments: Array, transforms: Array, planes: Array, before: Array, prior: Prior | None) -> Array:
    """One step of Gauss and Newton, in place. Returns the poses' information: the planes are eliminated.

    Unknown are 6 numbers of each lidar but the first (turn, shift) and 3 of each plane.
    """
    free = 6 * (len(transforms) - 1)
    information, mixed, solved, pose_pulls, axes = _equations(moments, transforms, planes)
    reduced: Array = information - np.einsum("pij,pjk->ik", mixed, solved[..., :free])
    known, pull = _of_prior(transforms, before, prior)
    of_planes = np.einsum("pij,pj->i", mixed, solved[..., free])
    step = np.linalg.solve(reduced + known, of_planes - pose_pulls.sum(axis=0) - pull)
    plane_steps = -solved[..., free] - solved[..., :free] @ step
    _move_poses(step, transforms)
    planes[:, :3] += plane_steps[:, 0, None] * axes[:, 0] + plane_steps[:, 1, None] * axes[:, 1]
    planes[:, 3] += plane_steps[:, 2]
    planes /= np.linalg.norm(planes[:, :3], axis=1)[:, None]
    return reduced


def _stds(moments: Array, transforms: Array, planes: Array, reduced: Array) -> Array:
    """(free,) of the poses: of independent points, or of patches that err as a whole if that is more."""
    free = len(reduced)
    covariance = np.linalg.inv(reduced)
    _, mixed, solved, pose_pulls, _ = _equations(moments, transforms, planes)
    of_patches = pose_pulls - np.einsum("pij,pj->pi", mixed, solved[..., free])
    together = covariance @ (of_patches.T @ of_patches) @ covariance
    stds: Array = np.sqrt(np.maximum(np.diag(covariance), np.diag(together)))
    return stds


def _equations(moments: Array, transforms: Array, planes: Array) -> tuple[Array, Array, Array, Array, Array]:
    """What a step is made of.

    (information (free, free) of the poses, mixed (p, free, 3) with the planes, solved (p, 3, free + 1): the
    planes' matrices solved for mixed and for their pulls, pulls (p, free) on the poses, axes (p, 2, 3))
    """
    lidars, free = len(transforms), 6 * (len(transforms) - 1)
    whole = transforms @ moments @ transforms.swapaxes(1, 2)
    pulled = (whole @ planes[:, None, :, None])[..., 0]
    axes = axes_of(planes[:, :3])
    # A plane turns about its own two axes, and moves along its normal.
    of_plane = np.zeros((len(planes), 3, 4))
    of_plane[:, :2, :3], of_plane[:, 2, 3] = axes, 1.0
    # A lidar's turn dw about the reference's axes moves p by dw x p, its distance by (p x n) . dw.
    of_pose = np.zeros((len(planes), 6, 4))
    of_pose[:, :3, :3], of_pose[:, 3:, 3] = -_crosses(planes[:, :3]), planes[:, :3]
    corner = of_plane @ whole.sum(axis=1) @ of_plane.swapaxes(1, 2)
    # A plane that one line of points alone carries could turn about it.
    corner += 1e-9 * np.trace(corner, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    plane_pull = np.einsum("pij,pkj->pi", of_plane, pulled)
    mixed = np.zeros((len(planes), free, 3))
    information, pose_pulls = np.zeros((free, free)), np.zeros((len(planes), free))
    for lidar in range(1, lidars):
        at = slice(6 * (lidar - 1), 6 * lidar)
        half = of_pose @ whole[:, lidar]
        mixed[:, at] = half @ of_plane.swapaxes(1, 2)
        information[at, at] = (half @ of_pose.swapaxes(1, 2)).sum(axis=0)
        pose_pulls[:, at] = np.einsum("pij,pj->pi", of_pose, pulled[:, lidar])
    right = np.concatenate((mixed.swapaxes(1, 2), plane_pull[..., None]), axis=2)
    return information, mixed, np.linalg.solve(corner, right), pose_pulls, axes


def _of_prior(transforms: Array, before: Array, prior: Prior | None) -> tuple[Array, Array]:
    """Information and gradient of the poses' deviation from those before."""
    free = 6 * (len(transforms) - 1)
    information, pull = np.zeros((free, free)), np.zeros(free)
    if prior is None:
        return information, pull
    weights = np.repeat([prior.rotation_rad**-2, prior.translation_m**-2], 3)
    for lidar in range(1, len(transforms)):
        at = slice(6 * (lidar - 1), 6 * lidar)
        now, then = transforms[lidar], before[lidar]
        turn = now[:3, :3] @ then[:3, :3].T
        skew = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        error = np.concatenate((skew, now[:3, 3] - then[:3, 3]))
        # A turn about the reference's origin moves the sensor, too.
        slope = np.eye(6)
        slope[3:, :3] = -_crosses(now[None, :3, 3])[0]
        information[at, at] = (slope.T * weights) @ slope
        pull[at] = (slope.T * weights) @ error
    return information, pull


def _move_poses(step: Array, transforms: Array) -> None:
    for lidar, (turn, shift) in enumerate(step.reshape(-1, 2, 3), start=1):
        rotation = rotation_of(turn)
        transforms[lidar, :3, :3] = rotation @ transforms[lidar, :3, :3]
        transforms[lidar, :3, 3] = rotation @ transforms[lidar, :3, 3] + shift


def _crosses(vectors: Array) -> Array:
    """(n, 3, 3) so that each times p is its vector x p."""
    crosses = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    crosses[:, 0, 1], crosses[:, 0, 2], crosses[:, 1, 2] = -z, y, -x
    crosses -= crosses.swapaxes(1, 2).copy()
    return crosses
