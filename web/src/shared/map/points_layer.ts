import type { OnboardScene } from "../scene/onboard_scene";
import type { MapLayer } from "./map_content";

/** Cells of the vehicle's height map are about so large. */
const POINT_M = 0.2;
const POINT_PX_MIN = 2;

/** Draws what the lidar found above the ground. */
export function pointsLayer({ points = [] }: OnboardScene): MapLayer {
  return (context, camera, palette) => {
    const size_m = Math.max(POINT_M, POINT_PX_MIN / camera.px_per_m);
    context.fillStyle = palette.ink;
    context.globalAlpha = 0.7;
    context.beginPath();
    for (let k = 0; k + 1 < points.length; k += 2)
      context.rect(points[k]! - size_m / 2, points[k + 1]! - size_m / 2, size_m, size_m);
    context.fill();
    context.globalAlpha = 1;
  };
}
