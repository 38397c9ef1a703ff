import type { AreaScene, Scene } from "./scene";

/** A camera's report that is older than this says nothing about now. */
export const PRESENCE_STALE_MS = 2_500;

export type AreaState = "clear" | "occupied" | "unknown";

/** What is known of an observation area: from its camera, and from the shuttles that watch it. */
export interface AreaObservation {
  readonly area_id: string;
  /** From the camera alone; unknown without a report or with a stale one. */
  readonly state: AreaState;
  /** The number of people in the camera's last report, and the report's age; null without a report. */
  readonly camera_count: number | null;
  readonly camera_age_ms: number | null;
  /** A shuttle sees a person in the area or on the way into it. */
  readonly seen_by_vehicle: boolean;
}

/** The observations of every area that a camera or a shuttle reports, sorted by id. */
export function areaObservations(scene: Scene, now_ms: number): AreaObservation[] {
  const seen = new Map<string, boolean>();
  for (const vehicle of scene.vehicles)
    for (const area of vehicle.status?.driving?.areas ?? [])
      seen.set(area.area_id, (seen.get(area.area_id) ?? false) || area.track_count > 0);
  const reports = new Map(scene.areas.map((area) => [area.area_id, area]));
  const area_ids = [...new Set([...seen.keys(), ...reports.keys()])].sort();
  return area_ids.map((area_id) => ({
    area_id,
    ...cameraObservation(reports.get(area_id), now_ms),
    seen_by_vehicle: seen.get(area_id) ?? false,
  }));
}

function cameraObservation(
  report: AreaScene | undefined,
  now_ms: number,
): Pick<AreaObservation, "state" | "camera_count" | "camera_age_ms"> {
  if (report === undefined) return { state: "unknown", camera_count: null, camera_age_ms: null };
  const camera_age_ms = Math.max(0, now_ms - report.heard_ms);
  const occupancy = report.count > 0 ? "occupied" : "clear";
  const state = camera_age_ms > PRESENCE_STALE_MS ? "unknown" : occupancy;
  return { state, camera_count: report.count, camera_age_ms };
}
