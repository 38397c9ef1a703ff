"""The maps that ship with the project, each read once."""

from functools import cache
from pathlib import Path

from contract.roads.load import load_map
from contract.roads.model import RoadMap

MAPS = Path(__file__).parents[3] / "maps"


@cache
def shipped_map(name: str) -> RoadMap:
    return load_map(MAPS / name / "map.json")
