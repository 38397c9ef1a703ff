import type { Schemas } from "../../shared/api/client";
import type { Point } from "../../shared/scene/scene";

export type Elements = Required<Schemas["Elements"]>;
export type Kind = keyof Elements;
export type Lane = Elements["lanes"][number];
export type Stop = Elements["stops"][number];

/** What a change puts and removes, as the server takes it. */
export interface Change {
  readonly put: Partial<Elements>;
  readonly removed: Partial<Record<Kind, string[]>>;
}

export const KINDS: readonly Kind[] = [
  "lanes",
  "stops",
  "resting_places",
  "observation_areas",
  "no_stopping_zones",
  "kerbs",
];

export const NOTHING: Elements = {
  lanes: [],
  stops: [],
  resting_places: [],
  observation_areas: [],
  no_stopping_zones: [],
  kerbs: [],
};

/** The elements of an answer; the client forgets that places are pairs. */
export function elementsOf(answer: unknown): Elements {
  return { ...NOTHING, ...(answer as Partial<Elements>) };
}

export function idOf(element: Elements[Kind][number]): string {
  if ("stop_id" in element) return element.stop_id;
  if ("place_id" in element) return element.place_id;
  if ("zone_id" in element) return element.zone_id;
  if ("area_id" in element) return element.area_id;
  if ("kerb_id" in element) return element.kerb_id;
  return element.lane_id;
}

/** The change that leads from one drawing to the other: equal objects were not touched. */
export function changeBetween(before: Elements, after: Elements): Change {
  const put: Partial<Record<Kind, unknown[]>> = {};
  const removed: Partial<Record<Kind, string[]>> = {};
  for (const kind of KINDS) {
    if (before[kind] === after[kind]) continue;
    const old = new Map<string, unknown>(before[kind].map((one) => [idOf(one), one]));
    const now = new Set(after[kind].map((one) => idOf(one)));
    const newer = after[kind].filter((one) => old.get(idOf(one)) !== one);
    const gone = [...old.keys()].filter((id) => !now.has(id));
    if (newer.length > 0) put[kind] = newer;
    if (gone.length > 0) removed[kind] = gone;
  }
  return { put: put as Partial<Elements>, removed };
}

export function isEmpty(change: Change): boolean {
  return Object.keys(change.put).length === 0 && Object.keys(change.removed).length === 0;
}

/** A name that no element of the kind has yet. */
export function freeId(elements: Elements, kind: Kind, stem: string): string {
  const taken = new Set(elements[kind].map((one) => idOf(one)));
  let number = 1;
  while (taken.has(`${stem}-${number}`)) number += 1;
  return `${stem}-${number}`;
}

/** The drawing with the element in the place of that of its id, or added. */
export function withElement<K extends Kind>(
  elements: Elements,
  kind: K,
  element: Elements[K][number],
): Elements {
  const list = elements[kind] as Elements[K][number][];
  const known = list.some((one) => idOf(one) === idOf(element));
  const next = known
    ? list.map((one) => (idOf(one) === idOf(element) ? element : one))
    : [...list, element];
  return { ...elements, [kind]: next };
}

/** The drawing without the element; without a lane, what lies on it goes too, and nothing leads to it. */
export function withoutElement(elements: Elements, kind: Kind, id: string): Elements {
  const next = { ...elements, [kind]: elements[kind].filter((one) => idOf(one) !== id) };
  if (kind !== "lanes") return next;
  return {
    ...next,
    lanes: next.lanes.map((lane) =>
      lane.successors.includes(id)
        ? { ...lane, successors: lane.successors.filter((name) => name !== id) }
        : lane,
    ),
    stops: next.stops.filter((stop) => stop.lane_id !== id),
    resting_places: next.resting_places.filter((place) => place.lane_id !== id),
    no_stopping_zones: next.no_stopping_zones.filter((zone) => zone.lane_id !== id),
    observation_areas: next.observation_areas.map((area) =>
      area.stop_lines.some(([lane_id]) => lane_id === id)
        ? { ...area, stop_lines: area.stop_lines.filter(([lane_id]) => lane_id !== id) }
        : area,
    ),
  };
}

export interface OnLane {
  readonly lane: Lane;
  readonly s_m: number;
  readonly away_m: number;
}

/** The lane that is nearest to a place, and where on it. */
export function nearestOnLane(lanes: readonly Lane[], at: Point): OnLane | null {
  let best: OnLane | null = null;
  for (const lane of lanes) {
    const found = along(lane.points, at);
    if (best === null || found.away_m < best.away_m) best = { lane, ...found };
  }
  return best;
}

/** Where a line is nearest to a place: metres along it, and metres away. */
export function along(points: readonly Point[], at: Point): { s_m: number; away_m: number } {
  let [best_s_m, best_m, s_m] = [0, Infinity, 0];
  for (let index = 1; index < points.length; index++) {
    const [[ax, ay], [bx, by]] = [points[index - 1]!, points[index]!];
    const [dx, dy] = [bx - ax, by - ay];
    const length_m = Math.hypot(dx, dy);
    const part = length_m === 0 ? 0 : ((at[0] - ax) * dx + (at[1] - ay) * dy) / length_m ** 2;
    const share = Math.min(1, Math.max(0, part));
    const away_m = Math.hypot(at[0] - ax - share * dx, at[1] - ay - share * dy);
    if (away_m < best_m) [best_m, best_s_m] = [away_m, s_m + share * length_m];
    s_m += length_m;
  }
  return { s_m: round(best_s_m, 3), away_m: best_m };
}

/** The place and heading at s_m on a line. */
export function poseAt(points: readonly Point[], s_m: number): { at: Point; yaw_rad: number } {
  let left_m = s_m;
  for (let index = 1; index < points.length; index++) {
    const [[ax, ay], [bx, by]] = [points[index - 1]!, points[index]!];
    const length_m = Math.hypot(bx - ax, by - ay);
    if (left_m <= length_m || index === points.length - 1) {
      const share = length_m === 0 ? 0 : Math.min(1, Math.max(0, left_m / length_m));
      return {
        at: [ax + share * (bx - ax), ay + share * (by - ay)],
        yaw_rad: Math.atan2(by - ay, bx - ax),
      };
    }
    left_m -= length_m;
  }
  return { at: points[0] ?? [0, 0], yaw_rad: 0 };
}

export function lengthOf_m(points: readonly Point[]): number {
  let sum_m = 0;
  for (let index = 1; index < points.length; index++)
    sum_m += Math.hypot(
      points[index]![0] - points[index - 1]![0],
      points[index]![1] - points[index - 1]![1],
    );
  return sum_m;
}

export function round(value: number, decimals: number): number {
  const factor = 10 ** decimals;
  return Math.round(value * factor) / factor;
}
