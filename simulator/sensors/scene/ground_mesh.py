"""The ground as triangles: fine along roads, where the kerb is a step, and coarse elsewhere."""

import numpy as np

from contract.geometry import Array
from simulator.sensors.scene.ground import CELL_M, Ground
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import Mesh, quads

# Fine cells of one coarse cell, along each axis.
_COARSE = 4
_FINE_FROM_M = -1.5
_PAVED_FROM_M = -2.5
# Corners of a cell, counter-clockwise: steps in columns and rows.
_CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))


def add_ground(mesh: Mesh, ground: Ground) -> None:
    """Road, kerbs, pavement and grass."""
    inside = ground.inside_m
    fine_nodes = inside > _FINE_FROM_M
    cells = fine_nodes[:-1, :-1] | fine_nodes[1:, :-1] | fine_nodes[:-1, 1:] | fine_nodes[1:, 1:]
    rows, columns = cells.shape
    blocks: np.ndarray = np.asarray(
        cells.reshape(rows // _COARSE, _COARSE, columns // _COARSE, _COARSE).any(axis=(1, 3))
    )
    fine = np.repeat(np.repeat(blocks, _COARSE, axis=0), _COARSE, axis=1)
    _add_coarse(mesh, ground, ~blocks)
    _add_fine(mesh, ground, fine)


def _add_coarse(mesh: Mesh, ground: Ground, blocks: np.ndarray) -> None:
    rows, columns = np.nonzero(blocks)
    if not len(rows):
        return
    size = CELL_M * _COARSE
    x = ground.corner[0] + size * (columns[:, None] + np.array([c for c, _ in _CORNERS]))
    y = ground.corner[1] + size * (rows[:, None] + np.array([r for _, r in _CORNERS]))
    z = ground.pavement_m(x.ravel(), y.ravel()).reshape(x.shape)
    mesh.add(quads(np.stack((x, y, z), axis=2)), Material.GRASS)


def _add_fine(mesh: Mesh, ground: Ground, fine: np.ndarray) -> None:
    rows, columns = np.nonzero(fine)
    node_rows = rows[:, None] + np.array([r for _, r in _CORNERS])
    node_columns = columns[:, None] + np.array([c for c, _ in _CORNERS])
    depth = ground.inside_m[node_rows, node_columns].astype(np.float64)
    x = ground.corner[0] + CELL_M * node_columns
    y = ground.corner[1] + CELL_M * node_rows
    on_road = depth > 0.0
    count = on_road.sum(axis=1)
    whole = count == 4
    z = ground.road_m(x[whole].ravel(), y[whole].ravel(), depth[whole].ravel()).reshape(-1, 4)
    mesh.add(quads(np.stack((x[whole], y[whole], z), axis=2)), Material.ASPHALT)
    outside = count == 0
    z = ground.pavement_m(x[outside].ravel(), y[outside].ravel()).reshape(-1, 4)
    beside = quads(np.stack((x[outside], y[outside], z), axis=2))
    is_paved = np.tile(depth[outside].max(axis=1) > _PAVED_FROM_M, 2)
    mesh.add(beside[is_paved], Material.PAVING)
    mesh.add(beside[~is_paved], Material.GRASS)
    cut = (count > 0) & (count < 4)
    _add_edges(mesh, ground, np.stack((x[cut], y[cut], depth[cut]), axis=2))


def _add_edges(mesh: Mesh, ground: Ground, cells: Array) -> None:
    """Cells (n, 4, 3) of x, y and depth that the road's edge crosses: each half of a cell is cut in two.

    Halves are triangles, so that the edge crosses each in one line, and neighbours meet in the same points.
    """
    halves = quads(cells)
    on_road = halves[:, :, 2] > 0.0
    count = on_road.sum(axis=1)
    whole, outside = halves[count == 3], halves[count == 0]
    mesh.add(_with_height(ground, whole, True), Material.ASPHALT)
    mesh.add(_with_height(ground, outside, False), Material.PAVING)
    mixed, lone_is_road = halves[(count == 1) | (count == 2)], (count == 1)[(count == 1) | (count == 2)]
    # The corner that is alone on its side comes first.
    lone = np.argmax((mixed[:, :, 2] > 0.0) == lone_is_road[:, None], axis=1)
    order = (lone[:, None] + np.arange(3)) % 3
    a, b, c = (mixed[np.arange(len(mixed)), order[:, k]] for k in range(3))
    p = a + (a[:, 2] / (a[:, 2] - b[:, 2]))[:, None] * (b - a)
    q = a + (a[:, 2] / (a[:, 2] - c[:, 2]))[:, None] * (c - a)
    lone_part = np.stack((a, p, q), axis=1)
    other_part = np.concatenate((np.stack((p, b, c), axis=1), np.stack((p, c, q), axis=1)))
    twice = np.tile(lone_is_road, 2)
    mesh.add(_with_height(ground, lone_part[lone_is_road], True), Material.ASPHALT)
    mesh.add(_with_height(ground, lone_part[~lone_is_road], False), Material.PAVING)
    mesh.add(_with_height(ground, other_part[~twice], True), Material.ASPHALT)
    mesh.add(_with_height(ground, other_part[twice], False), Material.PAVING)
    mesh.add(_kerb_faces(ground, p, q), Material.KERBSTONE)


def _with_height(ground: Ground, triangles: Array, is_road: bool) -> Array:
    """(n, 3, 3) triangles with the height in place of the depth."""
    x, y, depth = (triangles[:, :, k].ravel() for k in range(3))
    z = ground.road_m(x, y, depth) if is_road else ground.pavement_m(x, y)
    return np.column_stack((x, y, z)).reshape(-1, 3, 3)


def _kerb_faces(ground: Ground, p: Array, q: Array) -> Array:
    corners = []
    for end, height in ((p, "low"), (q, "low"), (q, "high"), (p, "high")):
        x, y = end[:, 0], end[:, 1]
        z = ground.terrain_m(x, y) if height == "low" else ground.pavement_m(x, y)
        corners.append(np.column_stack((x, y, z)))
    return quads(np.stack(corners, axis=1))
