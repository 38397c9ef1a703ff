import type { components } from "../api/schema";
import type { Point } from "../scene/scene";

export type Stop = Readonly<components["schemas"]["StopView"]>;

/** What the map draws of a campus, in metres in the map frame. */
export interface CampusGeometry {
  readonly map_version: string;
  readonly lanes: readonly {
    readonly lane_id: string;
    readonly kind: components["schemas"]["LaneShape"]["kind"];
    readonly name: string;
    readonly name_en: string;
    readonly points: readonly Point[];
    readonly width_m: number;
  }[];
  readonly buildings: readonly (readonly Point[])[];
  readonly stops: readonly Stop[];
  readonly areas: ReadonlyMap<string, readonly Point[]>;
}

type ApiGeometry = Pick<
  components["schemas"]["MapGeometry"],
  "map_version" | "lanes" | "buildings" | "stops" | "areas"
>;

export function campusGeometry(geometry: ApiGeometry): CampusGeometry {
  return {
    map_version: geometry.map_version,
    lanes: geometry.lanes.map((lane) => ({
      lane_id: lane.lane_id,
      kind: lane.kind,
      name: lane.name,
      name_en: lane.name_en,
      points: pointsOf(lane.xy),
      width_m: lane.width_m,
    })),
    buildings: geometry.buildings.map((building) => pointsOf(building.xy)),
    stops: geometry.stops,
    areas: new Map(geometry.areas.map((area) => [area.area_id, pointsOf(area.xy)])),
  };
}

/** x0, y0, x1, y1, ... as points. */
export function pointsOf(xy: readonly number[]): Point[] {
  const points: Point[] = [];
  for (let index = 0; index + 1 < xy.length; index += 2) points.push([xy[index]!, xy[index + 1]!]);
  return points;
}

/** A stop's name in the user's language, or in the other one if the campus has only that. */
export function stopName(stop: Stop, language: string): string {
  return language.startsWith("zh") ? stop.name || stop.name_en : stop.name_en || stop.name;
}

/** The stop's name, or its id when the map has no such stop. */
export function stopNameById(stops: readonly Stop[], stop_id: string, language: string): string {
  const stop = stops.find((candidate) => candidate.stop_id === stop_id);
  return stop === undefined ? stop_id : stopName(stop, language);
}

/** The stops whose names or id contain every term of the query. */
export function searchStops(stops: readonly Stop[], query: string): readonly Stop[] {
  const terms = query.toLocaleLowerCase().split(/\s+/).filter(Boolean);
  return stops.filter((stop) => {
    const text = `${stop.name} ${stop.name_en} ${stop.stop_id}`.toLocaleLowerCase();
    return terms.every((term) => text.includes(term));
  });
}
