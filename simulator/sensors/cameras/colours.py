"""Colours of surfaces in visible light, and the grain of each."""

import numpy as np

from contract.geometry import Array
from simulator.sensors.scene.materials import REFLECTIVITY, Material
from simulator.sensors.scene.static_scene import Array32, Surfaces

# Linear reflectances of red, green and blue, with the relative size of the surface's grain.
_VISIBLE: dict[Material, tuple[float, float, float, float]] = {
    Material.ASPHALT: (0.11, 0.11, 0.115, 0.10),
    Material.PAVING: (0.28, 0.26, 0.24, 0.12),
    Material.KERBSTONE: (0.34, 0.33, 0.31, 0.10),
    Material.GRASS: (0.07, 0.13, 0.035, 0.30),
    Material.PLASTER: (0.55, 0.51, 0.44, 0.05),
    Material.BRICK: (0.30, 0.13, 0.09, 0.18),
    Material.GLASS: (0.03, 0.035, 0.04, 0.0),
    Material.WOOD: (0.30, 0.19, 0.10, 0.15),
    Material.BARK: (0.13, 0.10, 0.07, 0.30),
    Material.FOLIAGE: (0.05, 0.11, 0.025, 0.45),
    Material.METAL: (0.30, 0.31, 0.32, 0.04),
    Material.CAR_PAINT: (0.30, 0.30, 0.30, 0.0),
    Material.RUBBER: (0.03, 0.03, 0.03, 0.05),
    Material.RETRO: (0.60, 0.60, 0.55, 0.0),
    Material.ROAD_MARKING: (0.60, 0.60, 0.58, 0.08),
    Material.CLOTHES: (0.25, 0.25, 0.28, 0.10),
}
_PAINTS = np.array(
    [(0.60, 0.60, 0.60), (0.03, 0.03, 0.035), (0.25, 0.26, 0.28), (0.35, 0.03, 0.03), (0.04, 0.09, 0.25),
     (0.45, 0.44, 0.40)]
)  # fmt: skip
_COLOURS: Array = np.array([_VISIBLE[material][:3] for material in Material])
GRAIN: Array32 = np.array([_VISIBLE[material][3] for material in Material], dtype=np.float32)


def triangle_colours(surfaces: Surfaces) -> Array32:
    """(n, 3) linear reflectances: the material's, by the shade that the lidar sees, too; cars in paints."""
    materials = surfaces.materials
    plain = np.array([REFLECTIVITY[material] for material in Material])
    shades = surfaces.reflectivity / plain[materials]
    colours = _COLOURS[materials] * np.clip(shades, 0.4, 1.8)[:, None]
    painted = materials == Material.CAR_PAINT
    if painted.any():
        colours[painted] = _PAINTS[surfaces.objects[painted] * 13 % len(_PAINTS)]
    clipped: Array32 = np.clip(colours, 0.0, 0.9).astype(np.float32)
    return clipped
