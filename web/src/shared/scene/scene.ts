import type { components } from "../api/schema";

/**
 * What a screen shows of the campus at one moment, live or replayed: the server's own schema. Times are
 * milliseconds since the Unix epoch, positions metres in the map frame (x east, y north), yaw
 * counter-clockwise from east.
 */
type Schemas = components["schemas"];

export type Scene = Readonly<Schemas["Scene"]>;
export type VehicleScene = Readonly<Schemas["VehicleScene"]>;
export type RideScene = Readonly<Schemas["RideScene"]>;
export type IncidentsScene = Readonly<Schemas["IncidentsScene"]>;
export type AreaScene = Readonly<Schemas["AreaScene"]>;
export type PictureScene = Readonly<Schemas["Picture"]>;
export type SceneMessage = Schemas["Snapshot"] | Schemas["Delta"];
export type RideState = Schemas["RideState"];

export type Point = readonly [x_m: number, y_m: number];

const ENDED: ReadonlySet<string> = new Set<RideState>([
  "completed",
  "refused",
  "cancelled",
  "no_show",
  "failed",
]);

export function hasEnded(state: string): boolean {
  return ENDED.has(state);
}

/** The shuttle stands at this stop with its doors open, so that it takes a tap. */
export function standsAt(vehicle: VehicleScene, stop_id: string): boolean {
  return vehicle.doors_open && vehicle.next_stop === stop_id;
}
