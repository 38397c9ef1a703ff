import type { Point } from "../../scene/scene";

/**
 * The part of a route ahead of (x_m, y_m): from the nearest point of the line to its end. If a route passes a
 * place twice, its first pass counts.
 */
export function routeAhead(route: readonly Point[], x_m: number, y_m: number): readonly Point[] {
  let best_m2 = Infinity;
  let best: { index: number; point: Point } | null = null;
  for (let index = 0; index + 1 < route.length; index += 1) {
    const point = nearestOn(route[index]!, route[index + 1]!, x_m, y_m);
    const distance_m2 = (point[0] - x_m) ** 2 + (point[1] - y_m) ** 2;
    if (distance_m2 < best_m2 - 1) {
      best_m2 = distance_m2;
      best = { index, point };
    }
  }
  if (best === null) return route;
  return [best.point, ...route.slice(best.index + 1)];
}

function nearestOn(a: Point, b: Point, x_m: number, y_m: number): Point {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const length2 = dx * dx + dy * dy;
  const share = length2 === 0 ? 0 : ((x_m - a[0]) * dx + (y_m - a[1]) * dy) / length2;
  const inside = Math.min(Math.max(share, 0), 1);
  return [a[0] + inside * dx, a[1] + inside * dy];
}
