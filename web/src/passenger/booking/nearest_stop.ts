import type { Schemas } from "../../shared/api/client";
import type { Stop } from "../../shared/campus/campus_geometry";

const EARTH_M = 6_371_008.8;
const WITHIN_MS = 10_000;

/** The longest walk to a stop. A phone farther away is not on the campus. */
export const NEAR_M = 3_000;

export type NearestStop =
  | { readonly kind: "found"; readonly stop_id: string; readonly away_m: number }
  | { readonly kind: "far" }
  | { readonly kind: "unknown" };

/** Phones tell pages their place over TLS only. */
export function canLocate(): boolean {
  return window.isSecureContext && "geolocation" in navigator;
}

export function locateNearest(
  stops: readonly Stop[],
  origin: Schemas["OriginView"],
): Promise<NearestStop> {
  return new Promise((resolve) => {
    navigator.geolocation.getCurrentPosition(
      ({ coords }) => resolve(nearestTo(coords.latitude, coords.longitude, stops, origin)),
      () => resolve({ kind: "unknown" }),
      { enableHighAccuracy: true, timeout: WITHIN_MS, maximumAge: 60_000 },
    );
  });
}

/** On a campus, a plane that touches the earth at its origin is exact enough. */
export function nearestTo(
  latitude_deg: number,
  longitude_deg: number,
  stops: readonly Stop[],
  origin: Schemas["OriginView"],
): NearestStop {
  const rad = Math.PI / 180;
  const y_m = EARTH_M * rad * (latitude_deg - origin.latitude_deg);
  const x_m =
    EARTH_M * rad * (longitude_deg - origin.longitude_deg) * Math.cos(rad * origin.latitude_deg);
  let nearest: { stop_id: string; away_m: number } | null = null;
  for (const stop of stops) {
    const away_m = Math.hypot(stop.x_m - x_m, stop.y_m - y_m);
    if (nearest === null || away_m < nearest.away_m) nearest = { stop_id: stop.stop_id, away_m };
  }
  if (nearest === null) return { kind: "unknown" };
  return nearest.away_m > NEAR_M ? { kind: "far" } : { kind: "found", ...nearest };
}
