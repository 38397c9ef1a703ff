import type { PathTimes } from "../../shared/scene/onboard_scene";

/** Ways from `0` to `way_m` and times from `0` to `time_s` fill the chart. */
export interface ChartScale {
  readonly width: number;
  readonly height: number;
  readonly time_s: number;
  readonly way_m: number;
}

/** Beyond the chosen way nothing is of interest but what comes next. */
const ROOM_M = 6;
const WAY_M_MIN = 10;

/** The scale on which the whole chosen motion can be seen, and a little beyond. */
export function scaleOf(times: PathTimes, width: number, height: number): ChartScale {
  const time_s = times.dt_s * Math.max(times.way_m.length - 1, 1);
  const way_m = Math.max(...times.way_m, 0) + ROOM_M;
  return { width, height, time_s, way_m: Math.max(way_m, WAY_M_MIN) };
}

function placed({ width, height, time_s, way_m }: ChartScale, at_s: number, at_m: number): string {
  const [x, y] = [(width * at_s) / time_s, height * (1 - at_m / way_m)];
  return `${round(x)} ${round(Math.min(Math.max(y, 0), height))}`;
}

function round(value: number): number {
  return Math.round(value * 10) / 10;
}

/** The line of a way over time; null: the corridor is open there, and the line is interrupted. */
export function wayLine(
  ways_m: readonly (number | null)[],
  dt_s: number,
  scale: ChartScale,
): string {
  let line = "";
  let pen = "M";
  ways_m.forEach((way_m, knot) => {
    if (way_m === null || way_m > scale.way_m) {
      pen = "M";
      return;
    }
    line += `${pen}${placed(scale, knot * dt_s, way_m)}`;
    pen = "L";
  });
  return line;
}

/** What a track occupies: one box a knot, half a knot to both sides. */
export function trackShape(
  [, , knots, from_m, to_m]: NonNullable<PathTimes["tracks"]>[number],
  dt_s: number,
  scale: ChartScale,
): string {
  return knots
    .map((knot, k) => {
      const [low_m, high_m] = [Math.max(from_m[k]!, 0), to_m[k]!];
      if (high_m < 0 || low_m > scale.way_m) return "";
      const begin_s = Math.max((knot - 0.5) * dt_s, 0);
      const end_s = Math.min((knot + 0.5) * dt_s, scale.time_s);
      const corners = [
        placed(scale, begin_s, low_m),
        placed(scale, end_s, low_m),
        placed(scale, end_s, high_m),
        placed(scale, begin_s, high_m),
      ];
      return `M${corners.join("L")}Z`;
    })
    .join("");
}
