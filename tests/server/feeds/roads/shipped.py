"""Where the shipped maps lie."""

from pathlib import Path

MAPS = Path(__file__).resolve().parents[4] / "maps"
CAMPUS = MAPS / "shanghai-university"
CAMPUS_SOURCE = CAMPUS / "shanghai-university-baoshan.osm.pbf"
CAMPUS_MAP = CAMPUS / "map.json"
SNOW_LION_MAP = MAPS / "snow-lion" / "map.json"
