import type { Point } from "../../shared/scene/scene";
import type { Elements, Lane } from "./drawing";
import { along, freeId, lengthOf_m, nearestOnLane, poseAt, round, withElement } from "./drawing";

/** How far along a lane a pulled point takes its neighbours with it. */
export const PULL_REACH_M = 15;
/** A drawn end this near to another lane's end is joined to it. */
export const JOIN_REACH_M = 3;
const SPACING_M = 0.95;
const NEW_SPEED_MPS = 15 / 3.6;
const NEW_WIDTH_M = 4;
const CROSSING_DEPTH_M = 4;
const PAVEMENT_M = 2;
const STOP_BEFORE_M = 0.5;

/** The lane with its place nearest to `from` pulled to `to`; what lies farther along stays, and so do joined ends. */
export function pulled(elements: Elements, lane_id: string, from: Point, to: Point): Elements {
  const lane = elements.lanes.find((one) => one.lane_id === lane_id);
  if (lane === undefined) return elements;
  const { s_m } = along(lane.points, from);
  const total_m = lengthOf_m(lane.points);
  const { at } = poseAt(lane.points, s_m);
  const [dx, dy] = [to[0] - at[0], to[1] - at[1]];
  let here_m = 0;
  const points = lane.points.map((point, index): [number, number] => {
    if (index > 0) here_m += lengthOf_m([lane.points[index - 1]!, point]);
    // Both ends stay where the neighbours meet them.
    const reach_m = Math.min(PULL_REACH_M, here_m < s_m ? s_m : total_m - s_m);
    const away = reach_m === 0 ? 1 : Math.min(1, Math.abs(here_m - s_m) / reach_m);
    const share = (1 - away ** 2) ** 2;
    return [round(point[0] + share * dx, 4), round(point[1] + share * dy, 4)];
  });
  return withElement(elements, "lanes", { ...lane, points });
}

/** A new lane through the clicked places, joined to the lanes whose ends are near its own. */
export function drawnLane(
  elements: Elements,
  clicked: readonly Point[],
): { elements: Elements; lane_id: string } {
  const lane_id = freeId(elements, "lanes", "lane");
  const first = nearestEnd(elements.lanes, clicked[0]!, -1);
  const last = nearestEnd(elements.lanes, clicked.at(-1)!, 0);
  const path = [...clicked];
  if (first !== null) path[0] = first.points.at(-1)!;
  if (last !== null) path[path.length - 1] = last.points[0]!;
  const lane: Lane = {
    lane_id,
    kind: "road",
    points: evenly(path),
    width_m: NEW_WIDTH_M,
    speed_limit_mps: NEW_SPEED_MPS,
    can_pass: false,
    successors: last === null ? [] : [last.lane_id],
    scenario: "common_road",
    name: "",
    name_en: "",
  };
  let next = withElement(elements, "lanes", lane);
  if (first !== null)
    next = withElement(next, "lanes", { ...first, successors: [...first.successors, lane_id] });
  return { elements: next, lane_id };
}

/** The lane cut in two where it is nearest to a place; what lay on it lies on the half that it was on. */
export function split(elements: Elements, lane_id: string, at: Point): Elements {
  const lane = elements.lanes.find((one) => one.lane_id === lane_id);
  if (lane === undefined) return elements;
  const cut_m = along(lane.points, at).s_m;
  const total_m = lengthOf_m(lane.points);
  if (cut_m < SPACING_M || cut_m > total_m - SPACING_M) return elements;
  const cut = poseAt(lane.points, cut_m).at;
  const middle: [number, number] = [round(cut[0], 4), round(cut[1], 4)];
  const before: [number, number][] = [];
  const after: [number, number][] = [middle];
  let s_m = 0;
  lane.points.forEach((point, index) => {
    if (index > 0) s_m += lengthOf_m([lane.points[index - 1]!, point]);
    if (s_m < cut_m - 0.05) before.push(point);
    else if (s_m > cut_m + 0.05) after.push(point);
  });
  const second_id = freeId(elements, "lanes", lane_id);
  const first: Lane = { ...lane, points: [...before, middle], successors: [second_id] };
  const second: Lane = { ...lane, lane_id: second_id, points: after };
  const moved = <T extends { lane_id: string; s_m: number }>(one: T): T =>
    one.lane_id === lane_id && one.s_m > cut_m
      ? { ...one, lane_id: second_id, s_m: round(one.s_m - cut_m, 3) }
      : one;
  return {
    ...elements,
    lanes: elements.lanes.flatMap((one) => (one.lane_id === lane_id ? [first, second] : [one])),
    stops: elements.stops.map(moved),
    resting_places: elements.resting_places.map(moved),
    observation_areas: elements.observation_areas.map((area) => ({
      ...area,
      stop_lines: area.stop_lines.map(([name, line_m]): [string, number] =>
        name === lane_id && line_m > cut_m ? [second_id, round(line_m - cut_m, 3)] : [name, line_m],
      ),
    })),
    no_stopping_zones: elements.no_stopping_zones.map((zone) =>
      zone.lane_id === lane_id && zone.s_from_m >= cut_m
        ? {
            ...zone,
            lane_id: second_id,
            s_from_m: round(zone.s_from_m - cut_m, 3),
            s_to_m: round(zone.s_to_m - cut_m, 3),
          }
        : zone.lane_id === lane_id
          ? { ...zone, s_to_m: Math.min(zone.s_to_m, cut_m) }
          : zone,
    ),
  };
}

export function withStop(elements: Elements, at: Point, name: string): Elements {
  const roads = elements.lanes.filter((lane) => lane.kind === "road");
  const near = nearestOnLane(roads, at);
  if (near === null) return elements;
  const stop_id = freeId(elements, "stops", "stop");
  return withElement(elements, "stops", {
    stop_id,
    name,
    name_en: "",
    lane_id: near.lane.lane_id,
    s_m: near.s_m,
    placed_by: "hand",
  });
}

/** A stop moved to the lane and place nearest to where it was put. */
export function stopMoved(elements: Elements, stop_id: string, to: Point): Elements {
  const stop = elements.stops.find((one) => one.stop_id === stop_id);
  const near = nearestOnLane(
    elements.lanes.filter((lane) => lane.kind === "road"),
    to,
  );
  if (stop === undefined || near === null) return elements;
  const moved = { ...stop, lane_id: near.lane.lane_id, s_m: near.s_m, placed_by: "hand" as const };
  return withElement(elements, "stops", moved);
}

/** A no-stopping zone between two places on the lane that is nearest to the first. */
export function withZone(elements: Elements, from: Point, to: Point): Elements {
  const near = nearestOnLane(elements.lanes, from);
  if (near === null) return elements;
  const end_m = along(near.lane.points, to).s_m;
  return withElement(elements, "no_stopping_zones", {
    zone_id: freeId(elements, "no_stopping_zones", "zone"),
    lane_id: near.lane.lane_id,
    s_from_m: Math.min(near.s_m, end_m),
    s_to_m: Math.max(near.s_m, end_m),
  });
}

/** A crossing over the road at a place: its ground, and a stop line on every lane that enters it. */
export function withCrossing(elements: Elements, at: Point): Elements {
  const near = nearestOnLane(elements.lanes, at);
  if (near === null) return elements;
  const { at: middle, yaw_rad } = poseAt(near.lane.points, near.s_m);
  const [half_m, side_m] = [CROSSING_DEPTH_M / 2, near.lane.width_m / 2 + PAVEMENT_M];
  const [cos, sin] = [Math.cos(yaw_rad), Math.sin(yaw_rad)];
  const corner = (x: number, y: number): [number, number] => [
    round(middle[0] + cos * x - sin * y, 2),
    round(middle[1] + sin * x + cos * y, 2),
  ];
  const is_inside = ([x, y]: Point): boolean => {
    const [dx, dy] = [x - middle[0], y - middle[1]];
    return Math.abs(cos * dx + sin * dy) <= half_m && Math.abs(cos * dy - sin * dx) <= side_m;
  };
  const stop_lines: [string, number][] = [];
  for (const lane of elements.lanes) {
    const entry = lane.points.findIndex((point) => is_inside(point));
    if (entry <= 0) continue;
    const s_m = lengthOf_m(lane.points.slice(0, entry + 1)) - STOP_BEFORE_M;
    if (s_m >= 0) stop_lines.push([lane.lane_id, round(s_m, 3)]);
  }
  return withElement(elements, "observation_areas", {
    area_id: freeId(elements, "observation_areas", "crossing-drawn"),
    kind: "crossing",
    outline: [
      corner(-half_m, -side_m),
      corner(half_m, -side_m),
      corner(half_m, side_m),
      corner(-half_m, side_m),
    ],
    stop_lines,
  });
}

/** A stop line of the area, on the lane that is nearest to a place. */
export function withStopLine(elements: Elements, area_id: string, at: Point): Elements {
  const area = elements.observation_areas.find((one) => one.area_id === area_id);
  const near = nearestOnLane(elements.lanes, at);
  if (area === undefined || near === null) return elements;
  const others = area.stop_lines.filter(([lane_id]) => lane_id !== near.lane.lane_id);
  const stop_lines: [string, number][] = [...others, [near.lane.lane_id, near.s_m]];
  return withElement(elements, "observation_areas", { ...area, stop_lines });
}

export function withKerb(elements: Elements, clicked: readonly Point[]): Elements {
  return withElement(elements, "kerbs", {
    kerb_id: freeId(elements, "kerbs", "kerb"),
    points: clicked.map(([x, y]): [number, number] => [round(x, 2), round(y, 2)]),
  });
}

/** The kerb with its point that is nearest to `from` moved by as much as `to` is away from it. */
export function kerbPulled(elements: Elements, kerb_id: string, from: Point, to: Point): Elements {
  const kerb = elements.kerbs.find((one) => one.kerb_id === kerb_id);
  if (kerb === undefined) return elements;
  const away_m = kerb.points.map(([x, y]) => Math.hypot(x - from[0], y - from[1]));
  const nearest = away_m.indexOf(Math.min(...away_m));
  const points = kerb.points.map(([x, y], index): [number, number] =>
    index === nearest ? [round(x + to[0] - from[0], 2), round(y + to[1] - from[1], 2)] : [x, y],
  );
  return withElement(elements, "kerbs", { ...kerb, points });
}

function nearestEnd(lanes: readonly Lane[], at: Point, which: 0 | -1): Lane | null {
  let [best, best_m]: [Lane | null, number] = [null, JOIN_REACH_M];
  for (const lane of lanes) {
    const end = lane.points.at(which);
    if (end === undefined) continue;
    const away_m = Math.hypot(end[0] - at[0], end[1] - at[1]);
    if (away_m <= best_m) [best, best_m] = [lane, away_m];
  }
  return best;
}

/** Points less than 1 m apart along a path. */
function evenly(path: readonly Point[]): [number, number][] {
  const total_m = lengthOf_m(path);
  const count = Math.max(1, Math.ceil(total_m / SPACING_M));
  return Array.from({ length: count + 1 }, (_, index) => {
    const { at } = poseAt(path, (total_m * index) / count);
    return [round(at[0], 4), round(at[1], 4)];
  });
}
