"""A small campus: one straight street with a house on either side."""

from contract.roads.model import Building, Lane, ObservationArea, Origin, RoadMap

HOUSES = (
    Building(((10.0, 8.0), (40.0, 8.0), (40.0, 20.0), (10.0, 20.0)), 9.0),
    Building(((55.0, -22.0), (85.0, -22.0), (85.0, -9.0), (55.0, -9.0)), 12.0),
)


def a_street(length_m: int = 120, buildings: tuple[Building, ...] = HOUSES) -> RoadMap:
    """Two lanes of 3.5 m along x, from 0, with a crossing in the middle."""
    ahead = tuple((float(x), -1.75) for x in range(length_m + 1))
    back = tuple((float(x), 1.75) for x in range(length_m, -1, -1))
    middle = 0.5 * length_m
    crossing = ObservationArea(
        "crossing", "crossing",
        ((middle - 2, -5.5), (middle + 2, -5.5), (middle + 2, 5.5), (middle - 2, 5.5)),
        (("east", middle - 4),),
    )  # fmt: skip
    return RoadMap(
        "street", "Street", Origin(31.3, 121.4),
        (
            Lane("east", "road", ahead, 3.5, 5.0, True, ("west",)),
            Lane("west", "road", back, 3.5, 5.0, True, ("east",)),
        ),
        (), (), (), buildings, observation_areas=(crossing,),
    )  # fmt: skip
