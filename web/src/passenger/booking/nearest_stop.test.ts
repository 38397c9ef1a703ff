import { expect, test } from "vitest";
import { nearestTo } from "./nearest_stop";

const origin = { latitude_deg: 31.31825, longitude_deg: 121.38865 };
const stop = (stop_id: string, x_m: number, y_m: number) => ({
  stop_id,
  name: "",
  name_en: "",
  lane_id: "",
  s_m: 0,
  x_m,
  y_m,
  placed_by: "tag",
});
const stops = [stop("gate", 0, 0), stop("library", 300, 400)];

test("the nearest stop is found by the phone's place", () => {
  expect(nearestTo(31.31825, 121.38865, stops, origin)).toMatchObject({ stop_id: "gate" });
  // 400 m north and 300 m east of the origin.
  const north = nearestTo(31.321847, 121.391808, stops, origin);
  expect(north).toMatchObject({ stop_id: "library" });
  expect(north.kind === "found" && north.away_m).toBeLessThan(2);
});

test("a phone in another town is told that it is far away", () => {
  expect(nearestTo(31.0, 121.0, stops, origin)).toEqual({ kind: "far" });
  expect(nearestTo(31.3, 121.4, [], origin)).toEqual({ kind: "unknown" });
});
