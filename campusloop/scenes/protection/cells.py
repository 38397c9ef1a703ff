"""Cells after the consumer tests, with people, cyclists, scooters and cars, by day and by night.

Without braking, each ends in a contact at a given share of the front's width.
"""

from collections.abc import Iterator

from campusloop.scenes.protection.cell import KMH, RANGES_M, Cell
from campusloop.scenes.protection.crossing import crossing, occluded, turning
from campusloop.scenes.protection.from_behind import from_behind
from campusloop.scenes.protection.longitudinal import longitudinal
from campusloop.scenes.protection.reversing_car import reversing_car
from vehicle_agent.config import Body

SPEEDS_KMH = (5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0)


def cells(body: Body) -> Iterator[Cell]:
    """All cells, in a fixed order."""
    for light in RANGES_M:
        for speed_kmh in SPEEDS_KMH:
            speed_mps = speed_kmh * KMH
            yield from crossing(body, light, speed_mps)
            yield from occluded(body, light, speed_mps)
            yield from longitudinal(body, light, speed_mps)
            yield from reversing_car(body, light, speed_mps)
            if speed_kmh <= 15.0:
                yield from turning(body, light, speed_mps)
    # Who overtakes is near enough to be seen by day and by night.
    for speed_kmh in SPEEDS_KMH:
        yield from from_behind(body, "day", speed_kmh * KMH)
