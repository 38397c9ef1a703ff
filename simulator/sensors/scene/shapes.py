"""Things of a street, each standing at the origin with x ahead: templates that are placed many times."""

import math

import numpy as np

from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import Mesh, PackedMesh, box, cylinder, quads, wheel


def tree(rng: np.random.Generator, leaves: int = 130) -> PackedMesh:
    """A tree 6 m to 10 m high: a trunk, some branches, and a crown of leaf clusters with gaps."""
    mesh = Mesh()
    height = rng.uniform(6.0, 10.0)
    clear, radius = height * rng.uniform(0.25, 0.35), height * rng.uniform(0.2, 0.3)
    girth = rng.uniform(0.09, 0.2)
    mesh.add(cylinder(girth, -0.4, 0.75 * height, 8, 0.4 * girth), Material.BARK)
    # Clusters are denser at the crown's surface.
    directions = rng.standard_normal((leaves, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    reach = rng.uniform(0.35, 1.0, leaves) ** 0.5
    extent = np.array([radius, radius, 0.5 * (height - clear)])
    middles = directions * reach[:, None] * extent + np.array([0.0, 0.0, 0.5 * (height + clear)])
    first = rng.standard_normal((leaves, 3))
    first *= (rng.uniform(0.2, 0.5, leaves) / np.linalg.norm(first, axis=1))[:, None]
    second = np.cross(first, rng.standard_normal((leaves, 3)))
    second *= (rng.uniform(0.2, 0.5, leaves) / np.linalg.norm(second, axis=1))[:, None]
    third = -first - 0.3 * second
    mesh.add(np.stack((middles + first, middles + second, middles + third), axis=1), Material.FOLIAGE)
    return mesh.packed()


def hedge(rng: np.random.Generator) -> PackedMesh:
    """A piece of 2 m of clipped hedge, 1 m high."""
    mesh = Mesh()
    count = 60
    places = rng.uniform((-1.0, -0.35, 0.05), (1.0, 0.35, 1.05), (count, 3))
    corners = places[:, None, :] + rng.uniform(-0.22, 0.22, (count, 3, 3))
    mesh.add(corners, Material.FOLIAGE, 0.9)
    return mesh.packed()


def lamp_post() -> PackedMesh:
    """A post of 5 m with an arm."""
    mesh = Mesh()
    mesh.add(cylinder(0.07, -0.3, 5.0), Material.METAL)
    mesh.add(box((-0.15, -0.05, 4.85), (0.15, 0.9, 5.0)), Material.METAL)
    return mesh.packed()


def bollard() -> PackedMesh:
    """A bollard with a retro-reflective band."""
    mesh = Mesh()
    mesh.add(cylinder(0.06, -0.2, 0.8), Material.METAL)
    mesh.add(cylinder(0.062, 0.8, 0.9), Material.RETRO)
    return mesh.packed()


def traffic_sign() -> PackedMesh:
    """A plate of 0.6 m with retro-reflective sheeting, which faces backwards (-x), on a post."""
    mesh = Mesh()
    mesh.add(cylinder(0.03, -0.3, 2.9), Material.METAL)
    plate = np.array([[-0.04, 0.3, 2.2], [-0.04, -0.3, 2.2], [-0.04, -0.3, 2.8], [-0.04, 0.3, 2.8]])
    mesh.add(quads(plate[None]), Material.RETRO)
    behind = plate + np.array([0.01, 0.0, 0.0])
    mesh.add(quads(behind[None]), Material.METAL)
    return mesh.packed()


def car() -> PackedMesh:
    """A car of 4.4 m x 1.8 m x 1.48 m with plates and lamps that reflect; the origin is its middle."""
    mesh = Mesh()
    mesh.add(box((-2.2, -0.9, 0.28), (2.2, 0.9, 0.85), 0.97), Material.CAR_PAINT)
    mesh.add(box((-1.65, -0.82, 0.85), (1.05, 0.82, 1.42), 0.72), Material.GLASS, 2.0)
    mesh.add(box((-1.25, -0.6, 1.40), (0.65, 0.6, 1.48), 0.98), Material.CAR_PAINT)
    for x_m in (-1.35, 1.4):
        for y_m in (-0.82, 0.82):
            mesh.add(wheel(x_m, y_m, 0.32, 0.2), Material.RUBBER)
    for x_m, sign in ((-2.205, -1.0), (2.205, 1.0)):
        plate = np.array([[x_m, -0.25, 0.45], [x_m, 0.25, 0.45], [x_m, 0.25, 0.56], [x_m, -0.25, 0.56]])
        mesh.add(quads(plate[None]), Material.RETRO)
        for y_m in (-0.72, 0.72):
            lamp = plate + np.array([0.0, y_m, 0.18])
            lamp[:, 1] = y_m + 0.3 * (lamp[:, 1] - y_m)
            mesh.add(quads(lamp[None]), Material.RETRO, 0.5 if sign > 0.0 else 0.8)
    return mesh.packed()


def truck() -> PackedMesh:
    """A delivery truck of 7 m x 2.3 m x 3.1 m; the origin is its middle."""
    mesh = Mesh()
    mesh.add(box((-3.5, -1.15, 0.9), (1.7, 1.15, 3.1)), Material.CAR_PAINT, 1.3)
    mesh.add(box((1.8, -1.05, 0.5), (3.5, 1.05, 2.3), 0.9), Material.CAR_PAINT)
    mesh.add(box((-3.3, -0.5, 0.5), (1.8, 0.5, 0.9)), Material.METAL)
    for x_m in (-2.3, 2.6):
        for y_m in (-1.0, 1.0):
            mesh.add(wheel(x_m, y_m, 0.42, 0.28), Material.RUBBER)
    plate = np.array([[-3.505, -0.9, 0.95], [-3.505, 0.9, 0.95], [-3.505, 0.9, 1.05], [-3.505, -0.9, 1.05]])
    mesh.add(quads(plate[None]), Material.RETRO)
    return mesh.packed()


def shuttle(length_m: float, width_m: float, height_m: float, rear_m: float) -> PackedMesh:
    """A shuttle whose origin is its rear axle on the ground."""
    mesh = Mesh()
    half = 0.5 * width_m
    front = length_m - rear_m
    mesh.add(box((-rear_m, -half, 0.3), (front, half, 0.5 * height_m), 0.98), Material.CAR_PAINT)
    mesh.add(
        box((-rear_m + 0.05, -half + 0.03, 0.5 * height_m), (front - 0.1, half - 0.03, height_m - 0.1), 0.94),
        Material.GLASS,
        2.0,
    )
    mesh.add(box((-rear_m, -half, height_m - 0.12), (front - 0.1, half, height_m), 0.97), Material.CAR_PAINT)
    for x_m in (0.0, front - 0.9):
        for y_m in (-half + 0.1, half - 0.1):
            mesh.add(wheel(x_m, y_m, 0.28, 0.18), Material.RUBBER)
    return mesh.packed()


def works() -> PackedMesh:
    """A building site of 8 m along x: barriers with retro-reflective stripes, a container, a heap."""
    mesh = Mesh()
    for k in range(5):
        x_m = -4.0 + 2.0 * k
        mesh.add(box((x_m - 0.9, -1.02, 0.75), (x_m + 0.9, -0.98, 1.0)), Material.RETRO)
        mesh.add(box((x_m - 0.9, -1.0, 0.2), (x_m + 0.9, -0.99, 0.7)), Material.WOOD)
        for end in (-0.85, 0.85):
            mesh.add(box((x_m + end - 0.04, -1.2, -0.2), (x_m + end + 0.04, -0.8, 0.2)), Material.RUBBER)
    mesh.add(box((-3.0, 0.6, 0.0), (0.0, 2.4, 2.4)), Material.METAL)
    mesh.add(cylinder(1.3, -0.2, 1.1, 12, 0.1) + np.array([2.2, 1.2, 0.0]), Material.GRASS, 0.7)
    return mesh.packed()


def person(height_m: float, stride_rad: float) -> PackedMesh:
    """A person who walks along x; stride_rad: how far the legs are apart, 0.0 standing."""
    mesh = Mesh()
    scale = height_m / 1.75
    parts = [
        cylinder(0.16, 0.85, 1.45, 8, 0.2) * np.array([0.75, 1.15, 1.0]),
        cylinder(0.06, 1.45, 1.52, 6),
        cylinder(0.09, 1.52, 1.75, 8, 0.08),
    ]
    for side, swing in ((-1.0, stride_rad), (1.0, -stride_rad)):
        parts.append(_limb(0.08, 0.85, 0.0, 0.11 * side, swing))
        parts.append(_limb(0.05, 1.42, 0.8, 0.26 * side, -0.8 * swing))
    mesh.add(np.concatenate(parts) * scale, Material.CLOTHES)
    return mesh.packed()


def _limb(radius_m: float, top_m: float, bottom_m: float, y_m: float, swing_rad: float) -> np.ndarray:
    """A leg or arm that hangs at top_m and swings forwards."""
    limb = cylinder(radius_m, bottom_m - top_m, 0.0, 6, 1.2 * radius_m)
    cos, sin = math.cos(swing_rad), math.sin(swing_rad)
    swung = limb.copy()
    swung[:, :, 0] = cos * limb[:, :, 0] - sin * limb[:, :, 2]
    swung[:, :, 2] = sin * limb[:, :, 0] + cos * limb[:, :, 2] + top_m
    swung[:, :, 1] += y_m
    return swung


def trees(seed: int, kinds: int = 8) -> list[PackedMesh]:
    """The trees of a campus."""
    return [tree(np.random.default_rng([seed, *b"tree", kind])) for kind in range(kinds)]
