import type { CampusGeometry, Stop } from "../../shared/campus/campus_geometry";
import { stopName } from "../../shared/campus/campus_geometry";
import type { Point } from "../../shared/scene/scene";

export type Lane = CampusGeometry["lanes"][number];

/** Two lanes whose ends lie this near to each other, the other way round, are one road's two directions. */
const SAME_ROAD_M = 8;

/** The road at a place, at most `reach_m` beside its edge; turns in junctions are no road. */
export function roadAt(lanes: readonly Lane[], at: Point, reach_m: number): Lane | null {
  let best: Lane | null = null;
  let best_m = Infinity;
  for (const lane of lanes) {
    if (lane.kind !== "road") continue;
    const away_m = distanceToLine_m(lane.points, at);
    if (away_m <= reach_m + lane.width_m / 2 && away_m < best_m) [best, best_m] = [lane, away_m];
  }
  return best;
}

/** The lanes that lead along the same road in the opposite direction. */
export function oppositeLanes(lanes: readonly Lane[], lane: Lane): readonly Lane[] {
  const [first, last] = [lane.points[0], lane.points.at(-1)];
  if (first === undefined || last === undefined) return [];
  return lanes.filter((other) => {
    const [begins, ends] = [other.points[0], other.points.at(-1)];
    if (other.kind !== "road" || begins === undefined || ends === undefined) return false;
    return (
      other !== lane &&
      distance_m(begins, last) < SAME_ROAD_M &&
      distance_m(ends, first) < SAME_ROAD_M &&
      Math.abs(length_m(other) - length_m(lane)) < SAME_ROAD_M
    );
  });
}

/** The road's own name, or the name of the stop that is nearest to its middle. */
export function roadName(
  lane: Lane,
  stops: readonly Stop[],
  language: string,
  near: (stop: string) => string,
): string {
  const own = language.startsWith("zh") ? lane.name || lane.name_en : lane.name_en || lane.name;
  if (own !== "") return own;
  const middle = lane.points[Math.floor(lane.points.length / 2)];
  if (middle === undefined) return lane.lane_id;
  const nearest = [...stops].sort(
    (a, b) => distance_m([a.x_m, a.y_m], middle) - distance_m([b.x_m, b.y_m], middle),
  )[0];
  return nearest === undefined ? lane.lane_id : near(stopName(nearest, language));
}

export function length_m(lane: Lane): number {
  let sum_m = 0;
  for (let index = 1; index < lane.points.length; index++)
    sum_m += distance_m(lane.points[index - 1]!, lane.points[index]!);
  return sum_m;
}

function distance_m([ax, ay]: Point, [bx, by]: Point): number {
  return Math.hypot(ax - bx, ay - by);
}

function distanceToLine_m(points: readonly Point[], at: Point): number {
  let nearest_m = Infinity;
  for (let index = 1; index < points.length; index++) {
    const [[ax, ay], [bx, by]] = [points[index - 1]!, points[index]!];
    const [dx, dy] = [bx - ax, by - ay];
    const squared = dx * dx + dy * dy;
    const along = squared === 0 ? 0 : ((at[0] - ax) * dx + (at[1] - ay) * dy) / squared;
    const part = Math.min(1, Math.max(0, along));
    nearest_m = Math.min(nearest_m, distance_m([ax + part * dx, ay + part * dy], at));
  }
  return nearest_m;
}
