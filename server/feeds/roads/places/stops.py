"""Stops: the tagged ones, moved onto lanes; where none is tagged, places by rule."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from contract.geometry import Array, arc_lengths, curvatures, pose_at
from contract.roads.design_vehicle import FRONT_REACH_M, REAR_OVERHANG_M
from contract.roads.model import Stop
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft
from server.feeds.roads.osm.buildings import Feature
from server.feeds.roads.osm.frame import Frame, inside
from server.feeds.roads.osm.osm_file import OsmData, OsmNode, Tags

REACH_M = 30.0
SPACING_M = 140.0
MOST = 16
# Where named buildings give fewer stops than one for 300 m of road, roads get some too.
_ROAD_PER_STOP_M = 300.0
_FEWEST = (4, 10)
# A stop this far from all others gains nothing from being farther still.
_FAR_M = 300.0
_AREA_EXPONENT = 0.3
_FEATURE_REACH_M = 60.0
_SITE_STEP_M = 6.0
_CURVATURE_MAX_1PM = 0.06
_FROM_END_M = 2.0
_WRONG_SIDE_M = 6.0
_ROAD_SPACING_M = 80.0
_OTHER_MODES = ("subway", "train", "tram", "light_rail", "monorail", "ferry", "aerialway", "funicular")
_DESTINATIONS = ("building", "leisure", "shop", "historic", "tourism", "amenity", "office")
_GROUNDS = ("university", "school", "college", "kindergarten", "parking", "bicycle_parking")


@dataclass(frozen=True, slots=True)
class Site:
    """A place on a lane where a shuttle can stand for boarding."""

    lane: LaneDraft
    s_m: float
    x_m: float
    y_m: float
    yaw_rad: float

    def side(self, x_m: float, y_m: float) -> float:
        """How far (x, y) lies to the left of the direction of travel."""
        dx, dy = x_m - self.x_m, y_m - self.y_m
        return math.cos(self.yaw_rad) * dy - math.sin(self.yaw_rad) * dx


def place_stops(
    data: OsmData,
    frame: Frame,
    found: Sequence[Feature],
    drafts: Sequence[LaneDraft],
    names_en: Mapping[str, str],
    log: ImportLog,
    *,
    left_hand: bool = False,
) -> tuple[Stop, ...]:
    """The stops of the map. Two usable tagged ones are enough not to place any by rule."""
    sites = _sites(drafts)
    if not sites:
        return ()
    door = 1.0 if left_hand else -1.0
    chosen = _tagged(data, frame, sites, door, log)
    tagged = len(chosen)
    if tagged < 2:
        chosen += _at_features(found, sites, door, [site for _, site, _ in chosen], log)
        chosen += _along_roads(drafts, sites, [site for _, site, _ in chosen], log)
    names = _distinct([name for name, _, _ in chosen])
    return tuple(
        Stop(
            f"stop-{number}",
            name,
            site.lane.lane_id,
            round(site.s_m, 3),
            name_en=english(name, tags, names_en),
            placed_by="tag" if number <= tagged else "rule",
        )
        for number, (name, (_, site, tags)) in enumerate(zip(names, chosen, strict=True), start=1)
    )


Chosen = tuple[str, Site, Tags]


def _sites(drafts: Sequence[LaneDraft]) -> list[Site]:
    """Places on roads, straight enough to board at and with the whole body clear of the junctions."""
    sites: list[Site] = []
    for draft in drafts:
        if draft.kind != "road":
            continue
        s, bend = arc_lengths(draft.points), np.abs(curvatures(draft.points))
        first, last = REAR_OVERHANG_M + _FROM_END_M, float(s[-1]) - FRONT_REACH_M - _FROM_END_M
        if last < first:
            continue
        for query in np.linspace(first, last, max(1, round((last - first) / _SITE_STEP_M) + 1)):
            near = (s > query - 4.0) & (s < query + 4.0)
            if bend[near].max(initial=0.0) <= _CURVATURE_MAX_1PM:
                sites.append(Site(draft, float(query), *pose_at(draft.points, s, float(query))))
    return sites


def is_tagged_stop(tags: Tags) -> bool:
    """A bus or shuttle stop, not one of another mode."""
    if any(tags.get(mode) == "yes" for mode in _OTHER_MODES) or "railway" in tags:
        return False
    return (
        tags.get("highway") == "bus_stop"
        or tags.get("public_transport") in ("platform", "stop_position")
        or tags.get("amenity") in ("shuttle", "shuttle_stop", "bus_station")
    )


def _tagged(data: OsmData, frame: Frame, sites: list[Site], door: float, log: ImportLog) -> list[Chosen]:
    nodes = [node for node in data.nodes.values() if is_tagged_stop(node.tags)]
    kept = inside(frame, [frame.positions[node.node_id] for node in nodes])
    chosen: list[Chosen] = []
    for node, is_inside in zip(nodes, kept, strict=True):
        if not is_inside:
            log.dropped.append(f"{_stop_label(node)}: outside the bounds")
            continue
        x, y = frame.positions[node.node_id]
        site = _nearest(sites, x, y, REACH_M, door)
        if site is None:
            log.dropped.append(f"{_stop_label(node)}: no lane within {REACH_M:.0f} m reaches it")
            continue
        if any(math.hypot(site.x_m - o.x_m, site.y_m - o.y_m) < _SITE_STEP_M for _, o, _ in chosen):
            log.dropped.append(f"{_stop_label(node)}: the same place as another stop")
            continue
        chosen.append((node.tags.get("name") or f"Stop {node.node_id}", site, node.tags))
    return chosen


def _stop_label(node: OsmNode) -> str:
    return f"stop {node.tags.get('name', node.node_id)}"


def _nearest(sites: list[Site], x: float, y: float, reach_m: float, door: float) -> Site | None:
    """The nearest site, one whose doors open towards (x, y) if there is one about as near."""
    best: tuple[float, int] | None = None
    for i, site in enumerate(sites):
        distance = math.hypot(site.x_m - x, site.y_m - y)
        if distance > reach_m:
            continue
        if site.side(x, y) * door < -0.5:
            distance += _WRONG_SIDE_M
        if best is None or (distance, i) < best:
            best = (distance, i)
    return None if best is None else sites[best[1]]


def _at_features(
    found: Sequence[Feature], sites: list[Site], door: float, taken: list[Site], log: ImportLog
) -> list[Chosen]:
    """Named destinations, large ones and ones far from the others first, none crowded."""
    candidates = _candidates(found, sites, door)
    chosen: list[Chosen] = []
    while len(taken) + len(chosen) < MOST:
        standing = [*taken, *(site for _, site, _ in chosen)]
        spread = [_spread(site, standing) for _, (_, site, _) in candidates]
        roomy = [k for k, gap_m in enumerate(spread) if gap_m >= SPACING_M]
        if not roomy:
            break
        merits = {k: min(spread[k], _FAR_M) * candidates[k][0] ** _AREA_EXPONENT for k in roomy}
        chosen.append(candidates.pop(max(roomy, key=lambda k: (merits[k], -k)))[1])
    if chosen:
        log.repairs.append(
            f"{len(chosen)} stops placed by rule at named buildings: the file tags none to use"
        )
    return chosen


def _spread(site: Site, standing: list[Site]) -> float:
    return min((_apart(site, other) for other in standing), default=math.inf)


def _candidates(found: Sequence[Feature], sites: list[Site], door: float) -> list[tuple[float, Chosen]]:
    """(area, choice) of every named destination with a site near it."""
    points = shapely.points([(site.x_m, site.y_m) for site in sites])
    candidates: list[tuple[float, Chosen]] = []
    for feature in found:
        name = feature.tags.get("name")
        if not name or not any(key in feature.tags for key in _DESTINATIONS):
            continue
        if feature.tags.get("amenity") in _GROUNDS and "building" not in feature.tags:
            continue
        distances: Array = shapely.distance(points, feature.outline)
        centre = feature.outline.centroid
        wrong = np.array([site.side(centre.x, centre.y) * door < 0.0 for site in sites])
        distances = distances + _WRONG_SIDE_M * wrong
        best = int(np.argmin(distances))
        if distances[best] <= _FEATURE_REACH_M:
            candidates.append((feature.outline.area, (name, sites[best], feature.tags)))
    return candidates


def _along_roads(
    drafts: Sequence[LaneDraft], sites: list[Site], taken: list[Site], log: ImportLog
) -> list[Chosen]:
    """Where buildings give too few, the roads' own names, as far from the others as can be."""
    road_m = sum(draft.length_m for draft in drafts if draft.kind == "road") / 2.0
    fewest = min(max(round(road_m / _ROAD_PER_STOP_M), _FEWEST[0]), _FEWEST[1])
    chosen: list[Chosen] = []
    while len(taken) + len(chosen) < fewest:
        standing = [*taken, *(site for _, site, _ in chosen)]
        spread = [_spread(site, standing) for site in sites]
        best = max(range(len(sites)), key=lambda k: (spread[k], bool(sites[k].lane.name), -k))
        if spread[best] < _ROAD_SPACING_M:
            break
        lane = sites[best].lane
        tags = {"name:en": lane.name_en} if lane.name_en else {}
        chosen.append((lane.name or "Stop", sites[best], tags))
    if chosen:
        log.repairs.append(f"{len(chosen)} stops placed by rule along roads: too few named buildings")
    return chosen


def _apart(one: Site, other: Site) -> float:
    return math.hypot(one.x_m - other.x_m, one.y_m - other.y_m)


def _distinct(names: Iterable[str]) -> list[str]:
    """Repeated names numbered from the second on."""
    seen: dict[str, int] = {}
    distinct = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        distinct.append(name if seen[name] == 1 else f"{name} {seen[name]}")
    return distinct


def english(name: str, tags: Tags, names_en: Mapping[str, str]) -> str:
    """The name in English: the given table, the tag, plain building letters and numbers; else empty."""
    if name in names_en:
        return names_en[name]
    if "name:en" in tags:
        number = re.search(r" \d+$", name)
        return tags["name:en"] + (number[0] if number else "")
    block = re.fullmatch(r"([A-Z]*\d*)号?(楼|公寓)", name)
    if block and block[1]:
        return f"{'Building' if block[2] == '楼' else 'Apartments'} {block[1]}"
    return name if name.isascii() else ""
