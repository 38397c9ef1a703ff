import { expect, test } from "vitest";
import type { PathTimes } from "../../shared/scene/onboard_scene";
import { scaleOf, trackShape, wayLine } from "./path_times_chart";

const times: PathTimes = {
  age_s: 0,
  dt_s: 1,
  way_m: [0, 2, 4],
  low_m: [null, null, null],
  high_m: [null, 3, 5],
  tracks: [],
  limits: [],
};
const scale = scaleOf(times, 200, 100);

test("the chart shows the whole motion and a little beyond", () => {
  expect(scale).toEqual({ width: 200, height: 100, time_s: 2, way_m: 10 });
});

test("way grows upwards and time to the right", () => {
  expect(wayLine(times.way_m, times.dt_s, scale)).toBe("M0 100L100 80L200 60");
});

test("an open corridor draws nothing", () => {
  expect(wayLine(times.high_m, times.dt_s, scale)).toBe("M100 70L200 50");
  expect(wayLine([null, 50], 1, scale)).toBe("");
});

test("a track is a box at each of its knots, cut at the chart's edges", () => {
  expect(trackShape([7, true, [1], [3], [5]], 1, scale)).toBe("M50 70L150 70L150 50L50 50Z");
  expect(trackShape([7, true, [2], [-4], [50]], 1, scale)).toBe("M150 100L200 100L200 0L150 0Z");
  expect(trackShape([7, true, [1], [-4], [-2]], 1, scale)).toBe("");
});
