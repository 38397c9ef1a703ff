import type { AreaScene, Scene } from "./scene";

/** A camera's report that is older than this says nothing about now. */
export const PRESENCE_STALE_MS = 2_500;

export type AreaState = "clear" | "occupied" | "unknown";

/** What is known of an observation area: by its camera, and by the shuttles that watch it themselves. */
export interface Watched {
  readonly area_id: string;
  /** By the camera alone; unknown when it is silent or too old. */
  readonly state: AreaState;
  /** How many people the camera last told of, and how long ago; null when it never did. */
  readonly told: number | null;
  readonly age_ms: number | null;
  /** Some shuttle sees somebody in it or coming into it. */
  readonly seen: boolean;
}

/** Every area that a camera or a shuttle told of, by id. */
export function watchedAreas(scene: Scene, now_ms: number): Watched[] {
  const seen = new Map<string, boolean>();
  for (const vehicle of scene.vehicles)
    for (const area of vehicle.picture?.areas ?? [])
      seen.set(area.area_id, (seen.get(area.area_id) ?? false) || area.coming > 0);
  const told = new Map(scene.areas.map((area) => [area.area_id, area]));
  const ids = [...new Set([...seen.keys(), ...told.keys()])].sort();
  return ids.map((area_id) => watched(area_id, told.get(area_id), seen.get(area_id), now_ms));
}

function watched(
  area_id: string,
  report: AreaScene | undefined,
  seen: boolean | undefined,
  now_ms: number,
): Watched {
  if (report === undefined)
    return { area_id, state: "unknown", told: null, age_ms: null, seen: seen ?? false };
  const age_ms = Math.max(0, now_ms - report.heard_ms);
  const state = age_ms > PRESENCE_STALE_MS ? "unknown" : report.count > 0 ? "occupied" : "clear";
  return { area_id, state, told: report.count, age_ms, seen: seen ?? false };
}
