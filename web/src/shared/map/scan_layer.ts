import type { Schemas } from "../api/client";
import type { MapLayer } from "./map_content";

/** Points of a scan are thinned to one in 0.8 m. */
const POINT_M = 0.3;
const POINT_PX_MIN = 3;

/** Draws a scan over the map: what lies on the map below what does not. */
export function scanLayer(scan: Readonly<Schemas["ScanMoment"]>): MapLayer {
  return (context, camera, { vehicle }) => {
    const size_m = Math.max(POINT_M, POINT_PX_MIN / camera.px_per_m);
    for (const [points, colour] of [
      [scan.agrees, vehicle.good],
      [scan.new, vehicle.warning],
      [scan.through, vehicle.danger],
    ] as const) {
      context.fillStyle = colour;
      context.beginPath();
      for (let k = 0; k + 1 < points.length; k += 2)
        context.rect(points[k]! - size_m / 2, points[k + 1]! - size_m / 2, size_m, size_m);
      context.fill();
    }
  };
}
