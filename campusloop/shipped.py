"""Where the maps and vehicle profiles lie that ship with the project."""

from pathlib import Path

_ROOT = Path(__file__).resolve().parents[1]

PROFILES = _ROOT / "vehicle_agent" / "profiles"
DEFAULT_MAP = _ROOT / "maps" / "shanghai-university" / "map.json"
SHIPPED_MAPS = (DEFAULT_MAP, _ROOT / "maps" / "snow-lion" / "map.json")
