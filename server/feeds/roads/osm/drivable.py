"""Which OpenStreetMap ways a shuttle may drive on, and what their tags say about driving there.

The rules are listed in docs/contract/roads.md.
"""

import re
from dataclasses import dataclass

from contract.roads.design_vehicle import WIDTH_M
from contract.roads.model import Scenario
from server.feeds.roads.osm.osm_file import Tags

SIDE_ROOM_M = 0.4
PASSING_WIDTH_M = 2.0 * (WIDTH_M + 2.0 * SIDE_ROOM_M)
LEAST_WIDTH_M = WIDTH_M + 2.0 * SIDE_ROOM_M
PATH_WIDTH_M = 3.0
LEAST_HEIGHT_M = 2.5
_LANE_WIDTH_M = 3.0
_MPH_MPS = 0.44704
_WALK_KMH = 7.0

# Class: assumed speed (km/h) and width (m).
ROADS = {
    "tertiary": (40.0, 7.0),
    "tertiary_link": (30.0, 5.0),
    "unclassified": (30.0, 6.0),
    "residential": (30.0, 6.0),
    "road": (20.0, 5.0),
    "service": (20.0, 4.0),
    "busway": (30.0, 4.0),
    "living_street": (10.0, 5.0),
}
# Driven only where a width of 3 m or more is tagged.
PATHS = ("path", "footway", "pedestrian", "cycleway", "track")
_PATH_KMH = 10.0
_PARKING_KMH = 10.0

# The most specific word wins: a shuttle is a public service vehicle.
_ACCESS_KEYS = ("bus", "psv", "motor_vehicle", "vehicle", "access")
_ALLOWED = {"yes", "designated", "permissive", "destination", "official", "permit", "customers", "students"}
_DENIED = {"no", "private", "agricultural", "forestry", "military", "delivery", "emergency", "discouraged"}
_CLOSED_BARRIERS = {
    "block", "bollard", "chain", "cycle_barrier", "debris", "fence", "full-height_turnstile",
    "horse_stile", "jersey_barrier", "kissing_gate", "log", "motorcycle_barrier", "planter", "stile",
    "turnstile", "wall",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Driving:
    """How a way may be driven: direction 1 along its nodes, -1 against them, 0 both ways."""

    direction: int
    speed_mps: float
    width_m: float
    can_pass: bool
    scenario: Scenario
    layer: int


def driving(tags: Tags) -> Driving | str | None:
    """How the way is driven; a reason where it looks like a road but is closed; None for anything else."""
    kind = tags.get("highway", "")
    if tags.get("area") == "yes" or (kind not in ROADS and kind not in PATHS):
        return None
    tagged_m = metres(tags.get("width", ""))
    if kind in PATHS and (tagged_m is None or tagged_m < PATH_WIDTH_M):
        return None
    if not may_enter(tags):
        return "closed to motor vehicles"
    if tags.get("service") in ("drive-through", "emergency_access"):
        return f"service={tags['service']}"
    if tagged_m is not None and tagged_m < LEAST_WIDTH_M:
        return f"{tagged_m:g} m wide, {LEAST_WIDTH_M:g} m needed"
    for key, least_m in (("maxheight", LEAST_HEIGHT_M), ("maxwidth", WIDTH_M + 0.2)):
        limit_m = metres(tags.get(key, ""))
        if limit_m is not None and limit_m < least_m:
            return f"{key}={limit_m:g} m"
    return _driving(kind, tags, tagged_m)


def _driving(kind: str, tags: Tags, tagged_m: float | None) -> Driving:
    direction = _direction(tags)
    lanes = _count(tags.get("lanes", ""))
    speed_kmh, assumed_m = ROADS.get(kind, (_PATH_KMH, PATH_WIDTH_M))
    parking = tags.get("service") == "parking_aisle"
    if parking:
        speed_kmh = _PARKING_KMH
    width_m = tagged_m or (lanes * _LANE_WIDTH_M if lanes else assumed_m)
    wide = (tagged_m is not None and tagged_m >= PASSING_WIDTH_M) or (tagged_m is None and lanes >= 2)
    return Driving(
        direction=direction,
        speed_mps=speed_mps(tags.get("maxspeed", "")) or speed_kmh / 3.6,
        width_m=width_m,
        can_pass=direction == 0 and wide,
        scenario="parking_lot" if parking else "common_road",
        layer=_layer(tags),
    )


def may_enter(tags: Tags) -> bool:
    """The access tags let a shuttle in; the most specific one decides, none of them means yes."""
    for key in _ACCESS_KEYS:
        value = tags.get(key)
        if value in _ALLOWED:
            return True
        if value in _DENIED:
            return False
    return True


def is_closed_barrier(tags: Tags) -> bool:
    """A node that a shuttle cannot drive through."""
    barrier = tags.get("barrier")
    if barrier is None:
        return False
    if barrier in _CLOSED_BARRIERS:
        return not any(tags.get(key) in _ALLOWED for key in _ACCESS_KEYS)
    return not may_enter(tags)


def metres(text: str) -> float | None:
    """A length tag in metres: "3", "3.5 m", "10'", "10 ft"; None where it is absent or unreadable."""
    match = re.fullmatch(r"\s*(\d+(?:[.,]\d+)?)\s*(m|ft|')?\s*", text)
    if match is None:
        return None
    value = float(match[1].replace(",", "."))
    return value * 0.3048 if match[2] in ("ft", "'") else value


def speed_mps(text: str) -> float | None:
    """A speed tag in m/s: "30", "30 km/h", "20 mph", "walk"; None where it is absent or says nothing."""
    if text.strip() == "walk":
        return _WALK_KMH / 3.6
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*(km/h|kmh|kph|mph)?\s*", text)
    if match is None or float(match[1]) == 0.0:
        return None
    return float(match[1]) * _MPH_MPS if match[2] == "mph" else float(match[1]) / 3.6


def _direction(tags: Tags) -> int:
    if any(tags.get(f"oneway:{kind}") == "no" for kind in ("bus", "psv")):
        return 0
    oneway = tags.get("oneway", "")
    if oneway in ("-1", "reverse"):
        return -1
    if oneway in ("yes", "1", "true"):
        return 1
    circular = tags.get("junction") in ("roundabout", "circular")
    return 1 if circular and oneway != "no" else 0


def _count(text: str) -> int:
    return int(text) if text.isdecimal() else 0


def _layer(tags: Tags) -> int:
    text = tags.get("layer", "")
    if re.fullmatch(r"[+-]?\d+", text):
        return int(text)
    if tags.get("bridge", "no") != "no":
        return 1
    return -1 if tags.get("tunnel", "no") not in ("no", "building_passage") else 0
