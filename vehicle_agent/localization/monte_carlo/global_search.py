"""Where in the whole map a scan may have been taken: the best poses of a lattice over all free space."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, IntArray
from vehicle_agent.localization.monte_carlo.likelihood_field import LikelihoodField
from vehicle_agent.localization.monte_carlo.particles import (
    climb,
    mean_over_beams,
    move,
    uniform_poses,
)
from vehicle_agent.localization.monte_carlo.random_numbers import GeneratorState


class GlobalSearchParams(msgspec.Struct, frozen=True):
    """The lattice and what is kept of it.

    spacing_m, spacing_rad  of the lattice
    poses_max               a greater lattice is thinned out by widening its spacing
    beams                   of the scan, evenly chosen
    apart_m, apart_rad      at most one of the best poses is taken from each square of this size and direction
    places                  so many best poses are refined
    kept                    particles that are spread over the refined poses
    spread_m, spread_rad    standard deviation of these particles about their pose
    """

    spacing_m: float = 0.25
    spacing_rad: float = 0.105
    poses_max: int = 4_000_000
    beams: int = 90
    apart_m: float = 0.75
    apart_rad: float = 0.315
    places: int = 800
    kept: int = 5000
    spread_m: float = 0.08
    spread_rad: float = 0.026


def global_poses(
    points: Array, field: LikelihoodField, params: GlobalSearchParams, random: GeneratorState
) -> Array:
    """(k, 3) particles where the scan fits best; k <= params.kept. The map needs a free cell.

    points (m, 2) ends of the beams in the laser's frame; without any, particles lie anywhere
    """
    if not len(points):
        return uniform_poses(field.free, params.kept, field.cell_m, random)
    chosen = points[np.linspace(0, len(points) - 1, min(params.beams, len(points))).astype(np.int64)]
    lattice = _lattice(field, params)
    place = (field.outside, field.origin_x_m, field.origin_y_m, field.cell_m)
    scores = mean_over_beams(lattice, chosen, field.coarse, *place)
    best = lattice[_best_apart(lattice, scores, params)]
    # The coarse field leads from between two poses of the lattice, the fine one to the end.
    for likelihoods in (field.coarse, field.log_likelihood):
        climb(best, chosen, likelihoods, *place, 0.5 * params.spacing_m, 0.5 * params.spacing_rad)
    poses = np.repeat(best, max(1, params.kept // len(best)), axis=0)
    move(poses, np.zeros(3), params.spread_m, params.spread_rad, 0.0, 0.0, 0.0, random)
    return poses


def _best_apart(lattice: Array, scores: Array, params: GlobalSearchParams) -> IntArray:
    """(k,) the best poses, of each square and direction the best one, k <= params.places."""
    size = np.array([params.apart_m, params.apart_m, params.apart_rad])
    order = np.argsort(-scores, kind="stable")[: 200 * params.places]
    _, first = np.unique(np.floor(lattice[order] / size).astype(np.int64), axis=0, return_index=True)
    return order[np.sort(first)[: params.places]]


def _lattice(field: LikelihoodField, params: GlobalSearchParams) -> Array:
    """(n, 3) one pose for each heading in each square of spacing_m that has a free cell."""
    headings = math.ceil(math.tau / params.spacing_rad)
    spacing_m = params.spacing_m
    places = _places(field.free, spacing_m)
    while len(places) * headings > params.poses_max:
        spacing_m *= 1.25
        places = _places(field.free, spacing_m)
    yaws_rad = -math.pi + math.tau / headings * (np.arange(headings) + 0.5)
    lattice = np.empty((len(places), headings, 3))
    lattice[:, :, :2] = places[:, None, :]
    lattice[:, :, 2] = yaws_rad
    return lattice.reshape(-1, 3)


def _places(free: Array, spacing_m: float) -> Array:
    """(k, 2) a free cell's middle in each square of this spacing, in order of rows."""
    squares = np.floor(free / spacing_m).astype(np.int64)
    _, first = np.unique(squares, axis=0, return_index=True)
    places: Array = free[np.sort(first)]
    return places
