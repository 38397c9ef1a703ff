import type { components } from "../api/schema";
import type { Point } from "../scene/scene";

export type Stop = Readonly<components["schemas"]["StopView"]>;

/** What the map draws of a campus; metres in the map frame. */
export interface CampusShape {
  readonly map_version: string;
  readonly lanes: readonly {
    readonly lane_id: string;
    readonly points: readonly Point[];
    readonly width_m: number;
  }[];
  readonly buildings: readonly (readonly Point[])[];
  readonly stops: readonly Stop[];
  readonly areas: ReadonlyMap<string, readonly Point[]>;
}

type Geometry = Pick<
  components["schemas"]["MapGeometry"],
  "map_version" | "lanes" | "buildings" | "stops" | "areas"
>;

export function campusShape(geometry: Geometry): CampusShape {
  return {
    map_version: geometry.map_version,
    lanes: geometry.lanes.map((lane) => ({
      lane_id: lane.lane_id,
      points: pairs(lane.xy),
      width_m: lane.width_m,
    })),
    buildings: geometry.buildings.map((building) => pairs(building.xy)),
    stops: geometry.stops,
    areas: new Map(geometry.areas.map((area) => [area.area_id, pairs(area.xy)])),
  };
}

/** x0, y0, x1, y1, ... as points. */
export function pairs(xy: readonly number[]): Point[] {
  const points: Point[] = [];
  for (let index = 0; index + 1 < xy.length; index += 2) points.push([xy[index]!, xy[index + 1]!]);
  return points;
}

/** A stop's name in the reader's language; campuses may name their stops in one language only. */
export function stopName(stop: Stop, language: string): string {
  return language.startsWith("zh") ? stop.name || stop.name_en : stop.name_en || stop.name;
}

/** The stop's name, or its bare id when this map does not know it. */
export function nameOfStop(stops: readonly Stop[], stop_id: string, language: string): string {
  const stop = stops.find((candidate) => candidate.stop_id === stop_id);
  return stop === undefined ? stop_id : stopName(stop, language);
}

/** Stops whose name in either language, or id, contains every term of the query. */
export function stopsMatching(stops: readonly Stop[], query: string): readonly Stop[] {
  const terms = query.toLocaleLowerCase().split(/\s+/).filter(Boolean);
  return stops.filter((stop) => {
    const text = `${stop.name} ${stop.name_en} ${stop.stop_id}`.toLocaleLowerCase();
    return terms.every((term) => text.includes(term));
  });
}
