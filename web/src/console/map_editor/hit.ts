import type { Point } from "../../shared/scene/scene";
import type { Elements } from "./drawing";
import { along, nearestOnLane, poseAt } from "./drawing";
import type { Chosen } from "./editor_state";

/** What was meant by a tap: small things before large ones; null for empty ground. */
export function elementAt(elements: Elements, at: Point, reach_m: number): Chosen | null {
  const lanes = new Map(elements.lanes.map((lane) => [lane.lane_id, lane]));
  const away_m = (lane_id: string, s_m: number): number => {
    const lane = lanes.get(lane_id);
    if (lane === undefined) return Infinity;
    const place = poseAt(lane.points, s_m).at;
    return Math.hypot(place[0] - at[0], place[1] - at[1]);
  };
  let best: Chosen | null = null;
  let best_m = reach_m;
  for (const stop of elements.stops) {
    const found_m = away_m(stop.lane_id, stop.s_m);
    if (found_m < best_m) [best, best_m] = [{ kind: "stops", id: stop.stop_id }, found_m];
  }
  if (best !== null) return best;
  for (const kerb of elements.kerbs)
    if (along(kerb.points, at).away_m < reach_m) return { kind: "kerbs", id: kerb.kerb_id };
  for (const zone of elements.no_stopping_zones) {
    const lane = lanes.get(zone.lane_id);
    if (lane === undefined) continue;
    const found = along(lane.points, at);
    const is_inside = found.s_m >= zone.s_from_m && found.s_m <= zone.s_to_m;
    if (is_inside && found.away_m < reach_m) return { kind: "no_stopping_zones", id: zone.zone_id };
  }
  const near = nearestOnLane(elements.lanes, at);
  if (near !== null && near.away_m < reach_m) return { kind: "lanes", id: near.lane.lane_id };
  const area = elements.observation_areas.find((one) => isInside(one.outline, at));
  return area === undefined ? null : { kind: "observation_areas", id: area.area_id };
}

/** The place is in the outline; even-odd rule. */
function isInside(outline: readonly Point[], [x, y]: Point): boolean {
  let odd = false;
  outline.forEach(([ax, ay], index) => {
    const [bx, by] = outline[(index + outline.length - 1) % outline.length]!;
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) odd = !odd;
  });
  return odd;
}
