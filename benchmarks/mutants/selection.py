"""Which tests a change is tried on, the nearest first."""

from pathlib import PurePosixPath

from benchmarks.mutants.importers import ImportGraph
from benchmarks.mutants.rooms import Room


def test_files(graph: ImportGraph, room: Room, path: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """(tests that mirror the room, the others that may see the change).

    The others are tests of the same package that import the file at whatever remove, and tests of any
    package that import it themselves.
    """
    distances = graph.distances(path)
    tests = [found for found in distances if PurePosixPath(found).name.startswith("test_")]
    mirror = f"test_{PurePosixPath(path).stem}.py"
    tests.sort(key=lambda found: (PurePosixPath(found).name != mirror, distances[found], found))
    near = [found for found in tests if found.startswith(room.tests)]
    package = f"tests/{path.partition('/')[0]}/"
    others = [
        found for found in tests if found not in near and (found.startswith(package) or distances[found] == 1)
    ]
    return tuple(near), tuple(others)
