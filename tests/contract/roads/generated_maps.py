"""Road maps that the real importer makes of generated campuses, each made once."""

import tempfile
from functools import cache
from pathlib import Path

from contract.roads.model import RoadMap
from server.feeds.roads.generated import generated_osm
from server.feeds.roads.import_osm import ImportReport, import_osm


@cache
def generated_report(seed: int) -> ImportReport:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / f"campus-{seed}.osm"
        source.write_bytes(generated_osm(seed))
        return import_osm(source)


def generated_map(seed: int) -> RoadMap:
    return generated_report(seed).map
