"""What surfaces are made of, as a lidar of 905 nm sees them.

Reflectivities are of the order of the ASTER/ECOSTRESS spectra at 0.9 um; each object has its own shade.
"""

from enum import IntEnum


class Material(IntEnum):
    """The index is what the scene stores for each triangle."""

    ASPHALT = 0
    PAVING = 1
    KERBSTONE = 2
    GRASS = 3
    PLASTER = 4
    BRICK = 5
    GLASS = 6
    WOOD = 7
    BARK = 8
    FOLIAGE = 9
    METAL = 10
    CAR_PAINT = 11
    RUBBER = 12
    RETRO = 13
    ROAD_MARKING = 14
    CLOTHES = 15


# Share of the light that a surface returns diffusely at right angles.
REFLECTIVITY: dict[Material, float] = {
    Material.ASPHALT: 0.14,
    Material.PAVING: 0.30,
    Material.KERBSTONE: 0.38,
    Material.GRASS: 0.45,
    Material.PLASTER: 0.55,
    Material.BRICK: 0.36,
    Material.GLASS: 0.05,
    Material.WOOD: 0.42,
    Material.BARK: 0.32,
    Material.FOLIAGE: 0.48,
    Material.METAL: 0.35,
    Material.CAR_PAINT: 0.38,
    Material.RUBBER: 0.05,
    Material.RETRO: 0.70,
    Material.ROAD_MARKING: 0.50,
    Material.CLOTHES: 0.38,
}
