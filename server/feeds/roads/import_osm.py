"""From an OpenStreetMap file to a road map: the page that names every step."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from contract.roads.load import MapError, with_version
from contract.roads.model import RoadMap
from contract.roads.validate import problems
from server.feeds.roads.lanes import sections
from server.feeds.roads.lanes.connectivity import largest_loop
from server.feeds.roads.lanes.drafts import ImportLog, LaneDraft, finished_lane
from server.feeds.roads.lanes.edges import Edge, edges_of
from server.feeds.roads.lanes.junctions import RoadGraph, gather
from server.feeds.roads.lanes.roads import (
    Road,
    cut_lanes,
    is_gentle,
    smooth_roads,
    trim,
)
from server.feeds.roads.lanes.turnarounds import turnaround_lanes
from server.feeds.roads.lanes.turns import turn_lanes
from server.feeds.roads.osm.buildings import (
    Feature,
    features,
    is_building,
    is_water,
    obstacles,
)
from server.feeds.roads.osm.frame import Frame, frame_of
from server.feeds.roads.osm.ground import Ground
from server.feeds.roads.osm.osm_file import Bounds, OsmData, read_osm
from server.feeds.roads.osm.way_segments import RoadPlan, WaySegment, drivable_segments
from server.feeds.roads.places.areas import observation_areas
from server.feeds.roads.places.parking import tag_parking
from server.feeds.roads.places.resting import resting_places
from server.feeds.roads.places.signs import road_signs
from server.feeds.roads.places.stops import place_stops

_FEWEST_STOPS = 2
_FEWEST_PLACES = 2
OSM_ATTRIBUTION = "© OpenStreetMap contributors, ODbL 1.0"


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """bounds: the box to keep, instead of the one that the file declares. left_hand: traffic keeps left.
    names_en: English names of stops that the file does not translate."""

    campus_id: str = "campus"
    name: str = "Campus"
    timezone: str = "UTC"
    bounds: Bounds | None = None
    left_hand: bool = False
    attribution: str = OSM_ATTRIBUTION
    names_en: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ImportReport:
    """The map, and everything that was changed or left out on the way to it."""

    map: RoadMap
    repairs: tuple[str, ...]
    dropped: tuple[str, ...]


def import_osm(path: Path, options: ImportOptions = ImportOptions()) -> ImportReport:
    """A drivable map from OSM XML or PBF; equal files and options give equal maps.

    Raises MapError with what to do: see `read_osm`, and no_roads, no_loop (no circuit that a shuttle can
    drive), no_stops, no_resting_places.
    """
    return import_data(read_osm(path), options, ImportLog())


def import_data(data: OsmData, options: ImportOptions, log: ImportLog) -> ImportReport:
    """The same from data that were read already. Raises MapError as `import_osm` does."""
    if options.bounds is not None:
        data = replace(data, bounds=options.bounds)
    frame = frame_of(data, log)
    found = features(data, frame)
    ground = Ground([f.outline for f in found if is_building(f) or is_water(f)])
    plan = drivable_segments(data, frame, log)
    if not plan.segments:
        raise MapError(
            "no_roads",
            "no road inside the bounds of the file may be driven on; docs/contract/roads.md has the rules",
        )
    drafts = _network(plan, ground, options, log)
    return _finish(data, frame, found, drafts, options, log)


def _network(plan: RoadPlan, ground: Ground, options: ImportOptions, log: ImportLog) -> list[LaneDraft]:
    """Lanes of the largest loop. Edges outside of it are removed and the rest is drawn again."""
    segments = plan.segments
    while True:
        round_log = ImportLog()
        graph = gather(edges_of(segments, plan.positions), plan.positions)
        roads = [road for road in smooth_roads(graph.edges, round_log) if not _is_tiny_ring(road, round_log)]
        drafts = _draw(graph, roads, plan, ground, options, round_log)
        kept = largest_loop(drafts)
        if not kept:
            raise MapError(
                "no_loop",
                "no circuit that a shuttle can drive (radius 5 m): "
                "export a larger area, or tag turning places at dead ends",
            )
        lost = _lost(graph, roads, kept)
        log.dropped += [
            line for line in round_log.dropped if line not in log.dropped and not line.startswith("turn ")
        ]
        if not lost:
            log.repairs += round_log.repairs
            log.dropped += [line for line in round_log.dropped if line.startswith("turn ")]
            return kept
        named = {edge.edge_id for road in roads for edge in (road.edge,)}
        log.dropped += [
            f"{edge.label}: not part of the largest loop, {edge.length_m:.0f} m"
            for edge in lost
            if edge.edge_id in named
        ]
        segments = _without(segments, lost)


def _is_tiny_ring(road: Road, log: ImportLog) -> bool:
    """A road back to its own beginning that is too short to turn on."""
    tiny = road.edge.keys[0] == road.edge.keys[-1] and road.edge.length_m < 40.0
    if tiny:
        log.dropped.append(f"{road.edge.label}: a ring of only {road.edge.length_m:.0f} m")
    return tiny


def _draw(
    graph: RoadGraph,
    roads: list[Road],
    plan: RoadPlan,
    ground: Ground,
    options: ImportOptions,
    log: ImportLog,
) -> list[LaneDraft]:
    trim(graph, roads)
    drafts = cut_lanes(roads, left_hand=options.left_hand)
    sharp = {draft.lane_id for draft in drafts if not is_gentle(draft)}
    drafts += turn_lanes(graph, roads, ground, log)
    drafts += turnaround_lanes(graph, roads, plan.turning_circles, ground, log)
    good = [draft for draft in drafts if draft.lane_id not in sharp]
    for draft in good:
        draft.successors = [name for name in draft.successors if name not in sharp]
    return good


def _lost(graph: RoadGraph, roads: list[Road], kept: list[LaneDraft]) -> list[Edge]:
    """The edges of which no lane is left."""
    names = {draft.lane_id for draft in kept}
    used = {
        road.edge.edge_id
        for road in roads
        if any(lane is not None and lane.lane_id in names for lane in (road.forward, road.backward))
    }
    return [edge for edge in graph.edges if edge.edge_id not in used]


def _without(segments: list[WaySegment], lost: Iterable[Edge]) -> list[WaySegment]:
    gone = {frozenset(step) for edge in lost for step in zip(edge.keys, edge.keys[1:], strict=False)}
    rest_of: list[WaySegment] = []
    for segment in segments:
        pieces: list[list[int]] = []
        for first, second in zip(segment.keys, segment.keys[1:], strict=False):
            if frozenset((first, second)) in gone:
                continue
            if pieces and pieces[-1][-1] == first:
                pieces[-1].append(second)
            else:
                pieces.append([first, second])
        rest_of += [replace(segment, keys=tuple(piece)) for piece in pieces]
    return rest_of


def _finish(
    data: OsmData,
    frame: Frame,
    found: list[Feature],
    drafts: list[LaneDraft],
    options: ImportOptions,
    log: ImportLog,
) -> ImportReport:
    tiles = sections.tile(drafts)
    stops = place_stops(data, frame, found, drafts, options.names_en, log, left_hand=options.left_hand)
    if len(stops) < _FEWEST_STOPS:
        raise MapError("no_stops", "no room for two stops on the roads that are left; export a larger area")
    areas = observation_areas(data, frame, drafts)
    road_map = RoadMap(
        campus_id=options.campus_id,
        name=options.name,
        origin=frame.origin,
        lanes=tuple(finished_lane(draft) for draft in drafts),
        sections=tiles,
        stops=stops,
        resting_places=(),
        buildings=obstacles(found, drafts, log),
        timezone=options.timezone,
        attribution=options.attribution,
        observation_areas=areas,
        signs=road_signs(data, frame, drafts, areas, left_hand=options.left_hand),
    )
    road_map = _with_resting_places(road_map, log)
    # Only now: nobody should rest before the way out of a car park.
    log.repairs += tag_parking(data, frame, found, drafts)
    road_map = msgspec.structs.replace(road_map, lanes=tuple(finished_lane(draft) for draft in drafts))
    road_map = with_version(msgspec.structs.replace(road_map, repairs=tuple(log.repairs)))
    defects = problems(road_map)
    if defects:
        raise MapError("unsound", f"{defects[0].where}: {defects[0].detail}; please report this file")
    return ImportReport(road_map, tuple(log.repairs), tuple(log.dropped))


def _with_resting_places(road_map: RoadMap, log: ImportLog) -> RoadMap:
    """Room to rest; on a small map, stops placed by rule give way to it, the last one first."""
    while True:
        places = resting_places(road_map)
        spare = [stop for stop in road_map.stops if stop.placed_by == "rule"]
        if len(places) >= _FEWEST_PLACES or not spare or len(road_map.stops) <= _FEWEST_STOPS:
            break
        log.repairs.append(f"stop {spare[-1].name}: given up, since it left no room for shuttles to rest")
        kept = tuple(stop for stop in road_map.stops if stop is not spare[-1])
        road_map = msgspec.structs.replace(road_map, stops=kept)
    if not places:
        raise MapError(
            "no_resting_places",
            "nowhere to stand without cutting a stop off; export a larger area with more than one circuit",
        )
    return msgspec.structs.replace(road_map, resting_places=places)
