"""Where the maps and vehicle profiles lie that ship with the project."""

from pathlib import Path

_ROOT = Path(__file__).resolve().parents[1]

PROFILES = _ROOT / "vehicle_agent" / "profiles"
DEFAULT_MAP = _ROOT / "maps" / "shanghai-university" / "map.json"
SHIPPED_MAPS = (DEFAULT_MAP, _ROOT / "maps" / "snow-lion" / "map.json")


def occupancy_map_of(campus_map: Path) -> Path | None:
    """The occupancy map that ships beside a campus map; None without one."""
    folder = campus_map.parent / "occupancy-map"
    return folder if folder.is_dir() else None
