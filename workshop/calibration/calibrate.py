"""The poses of several lidars to one of them, from scans of one scene: planes, a first guess, registration,
adjustment.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from contract.geometry import Array
from contract.transforms import apart
from workshop.calibration.adjustment import Adjustment, Patch, Prior, adjust
from workshop.calibration.errors import CalibrationError
from workshop.calibration.matching import from_ground, from_planes, turned
from workshop.calibration.patches import PatchSearch, find_patches
from workshop.calibration.planes import Plane, PlaneSearch, find_planes
from workshop.calibration.registration import Surfaces, fitting_share, register, sample, surfaces_of
from workshop.calibration.residuals import distance_m


@dataclass(frozen=True, slots=True)
class CalibrationParams:
    """Parameters of a calibration.

    share_min           of `fitting_share` at which scans fit
    ambiguous_ratio     another pose fits alike if its share is this part of the best one's
    tried               first guesses that are registered, the best by their share
    gates_m             distances of points from their patches, round by round
    std_m_max, std_rad_max  standard deviations above which a pose is not determined
    facing_min          points on patches that face the direction that is seen worst; a street without ends
                        has a few dozen, from the edges of things, and a corner a thousand
    """

    planes: PlaneSearch = field(default_factory=PlaneSearch)
    patches: PatchSearch = field(default_factory=PatchSearch)
    prior: Prior = field(default_factory=Prior)
    share_min: float = 0.2
    ambiguous_ratio: float = 0.9
    tried: int = 6
    gates_m: tuple[float, ...] = (0.3, 0.2, 0.15)
    std_m_max: float = 0.1
    std_rad_max: float = 0.01
    facing_min: float = 150.0


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """What a calibration found.

    names       of the lidars, the reference first
    transforms  (k, 4, 4) T_reference_sensor
    stds        (k, 6) standard deviations: rotation (rad), translation (m), along the reference's axes
    shares      (k,) how well each scan fits the reference's surfaces
    planes      how many planes each lidar sees
    patches     what was adjusted, and (p, 4) its planes in the reference's frame
    kept        the given pose fits better than any that was found, and stays
    """

    names: tuple[str, ...]
    transforms: Array
    stds: Array
    shares: Array
    planes: tuple[int, ...]
    patches: tuple[Patch, ...]
    patch_planes: Array
    deviations_m: Array
    kept: tuple[bool, ...]


# A pose that differs from the best one by more than this is another one.
_OTHER_M, _OTHER_RAD = 0.5, math.radians(8.0)
# Yaws that are tried around a guess.
_YAWS_RAD = np.radians([-20.0, 20.0])
_POINTS_MIN = 500

Step = Callable[[str], None]


def calibrate(
    names: Sequence[str],
    clouds: Sequence[Array],
    guesses: Sequence[Array | None],
    params: CalibrationParams | None = None,
    step: Step = lambda _: None,
) -> Calibration:
    """The poses of these lidars to the first one; deterministic.

    clouds   (n, 3) of each lidar, its own frame, taken while nothing moved
    guesses  (4, 4) T_reference_sensor of each, None where nothing is known; the first is not used
    step     is told what is done, for a bar of progress
    CalibrationError says why it is refused.
    """
    params = params or CalibrationParams()
    if len(clouds) < 2:
        raise CalibrationError("too_few_lidars", f"{len(clouds)} lidar; a calibration needs two")
    points = [cloud.astype(np.float64) for cloud in clouds]
    for name, cloud in zip(names, points, strict=True):
        if len(cloud) < _POINTS_MIN:
            raise CalibrationError("too_few_points", f"{name} has {len(cloud)} points")
    planes = []
    for name, cloud in zip(names, points, strict=True):
        step(f"planes of {name}")
        planes.append(find_planes(cloud, params.planes))
    surfaces = surfaces_of(_near(points[0], params.planes.range_m_max), planes[0])
    transforms, shares = [np.eye(4)], [1.0]
    for number in range(1, len(points)):
        step(f"first guess of {names[number]}")
        source = sample(_near(points[number], params.planes.range_m_max))
        starts = _starts(names[number], planes[0], planes[number], guesses[number])
        transform, share = _best(names[number], source, surfaces, starts, params)
        transforms.append(transform)
        shares.append(share)
    adjustment, patches = _adjusted(names, points, np.array(transforms), params, step)
    poses, kept = _no_worse_than_given(points, adjustment.transforms, guesses)
    return Calibration(
        tuple(names), poses, adjustment.stds, np.array(shares), tuple(map(len, planes)),
        tuple(patches), adjustment.planes, adjustment.deviations_m, kept,
    )  # fmt: skip


def _no_worse_than_given(
    points: list[Array], found: Array, guesses: Sequence[Array | None]
) -> tuple[Array, tuple[bool, ...]]:
    """The poses found, but the given one of a lidar where that fits the reference's surfaces better."""
    poses, kept = found.copy(), [False] * len(points)
    if all(guess is None for guess in guesses[1:]):
        return poses, tuple(kept)
    surfaces = surfaces_of(points[0])
    for number in range(1, len(points)):
        guess = guesses[number]
        if guess is None:
            continue
        ours, given = (distance_m(surfaces, points[number], pose) for pose in (found[number], guess))
        if given < ours:
            poses[number], kept[number] = guess, True
    return poses, tuple(kept)


def _near(points: Array, range_m: float) -> Array:
    near: Array = points[np.linalg.norm(points, axis=1) < range_m]
    return near


def _starts(name: str, reference: list[Plane], other: list[Plane], guess: Array | None) -> list[Array]:
    starts = from_planes(reference, other)
    if guess is not None:
        for near in (guess, *turned(guess, _YAWS_RAD)):
            starts += [near, *from_ground(reference, other, near)]
    if not starts:
        raise CalibrationError(
            "too_few_planes",
            f"{name} sees {len(other)} planes and the reference {len(reference)}, no three of them alike; "
            "drive to a corner of two walls, or give a guess of its pose",
        )
    return starts


def _best(
    name: str, source: Array, surfaces: Surfaces, starts: list[Array], params: CalibrationParams
) -> tuple[Array, float]:
    """The pose at which most of the source lies on surfaces."""
    before = [fitting_share(source, surfaces, start) for start in starts]
    chosen: list[Array] = []
    for number in np.argsort(before)[::-1]:
        # Starts that are alike lead to the same pose.
        if all(_differ(starts[number], other) for other in chosen):
            chosen.append(starts[number])
        if len(chosen) == params.tried:
            break
    found = [register(source, surfaces, start) for start in chosen]
    shares = [fitting_share(source, surfaces, transform) for transform in found]
    best = int(np.argmax(shares))
    if shares[best] < params.share_min:
        raise CalibrationError(
            "no_match", f"{name} fits the reference at no pose: the best share is {shares[best]:.2f}"
        )
    others = [s for t, s in zip(found, shares, strict=True) if _differ(t, found[best])]
    if others and max(others) > params.ambiguous_ratio * shares[best]:
        raise CalibrationError(
            "ambiguous",
            f"{name} fits at two poses ({shares[best]:.2f} and {max(others):.2f}); give a guess of its pose",
        )
    return found[best], shares[best]


def _differ(one: Array, other: Array) -> bool:
    metres, angle_rad = apart(one, other)
    return metres > _OTHER_M or angle_rad > _OTHER_RAD


def _adjusted(
    names: Sequence[str], points: list[Array], start: Array, params: CalibrationParams, step: Step
) -> tuple[Adjustment, list[Patch]]:
    transforms = start
    adjustment: Adjustment | None = None
    patches: list[Patch] = []
    for number, gate_m in enumerate(params.gates_m, start=1):
        step(f"adjustment {number} of {len(params.gates_m)}")
        near = [_near(cloud, params.planes.range_m_max) for cloud in points]
        patches = find_patches(near, transforms, gate_m, params.patches)
        seen = np.array([[len(part) > 0 for part in patch.points] for patch in patches]).reshape(
            -1, len(points)
        )
        for lidar, count in enumerate(seen.sum(axis=0)):
            if count < 3:
                raise CalibrationError("degenerate", f"{names[lidar]} shares {count} planes with the others")
        try:
            adjustment = adjust(patches, start, params.prior)
        except np.linalg.LinAlgError as error:
            raise CalibrationError("degenerate", "the common planes leave a direction open") from error
        transforms = adjustment.transforms
    assert adjustment is not None
    _check_determined(names, adjustment, patches, params)
    return adjustment, patches


def _check_determined(
    names: Sequence[str], adjustment: Adjustment, patches: list[Patch], params: CalibrationParams
) -> None:
    """Noise tilts the planes of a street a little: standard deviations alone see ends that are not there."""
    counts = np.array([[len(part) for part in patch.points] for patch in patches])
    normals, most = adjustment.planes[:, :3], params.patches.points_max
    for lidar in range(1, len(names)):
        weights = np.where(counts[:, lidar] > 0, np.minimum(counts.sum(axis=1), most), 0)
        facing = float(np.linalg.eigvalsh((normals.T * weights) @ normals)[0])
        if facing < params.facing_min:
            raise CalibrationError(
                "degenerate",
                f"{names[lidar]} shares {facing:.0f} points that face the worst direction, of "
                f"{params.facing_min:.0f}; the scene needs walls in two directions",
            )
    for name, stds in zip(names, adjustment.stds, strict=True):
        turn_rad, shift_m = float(np.max(stds[:3])), float(np.max(stds[3:]))
        if not (turn_rad <= params.std_rad_max and shift_m <= params.std_m_max):
            raise CalibrationError(
                "degenerate",
                f"the planes that {name} shares leave it open by {100 * shift_m:.0f} cm and "
                f"{math.degrees(turn_rad):.2f} degrees; the scene needs walls in two directions",
            )
