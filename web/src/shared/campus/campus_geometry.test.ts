import { expect, test } from "vitest";
import type { Stop } from "./campus_geometry";
import { pointsOf, searchStops, stopName, stopNameById } from "./campus_geometry";

function aStop(stop_id: string, name: string, name_en: string): Stop {
  return { stop_id, name, name_en, lane_id: "l", s_m: 0, x_m: 0, y_m: 0, placed_by: "tag" };
}

const stops = [
  aStop("stop-1", "图书馆", "Main Library"),
  aStop("stop-2", "体育馆", "Gymnasium"),
  aStop("stop-3", "东门", ""),
];

test("flat coordinates become points", () => {
  expect(pointsOf([1, 2, 3, 4])).toEqual([
    [1, 2],
    [3, 4],
  ]);
});

test("a stop is named in the user's language, or else in the other one", () => {
  expect(stopName(stops[0]!, "en")).toBe("Main Library");
  expect(stopName(stops[0]!, "zh-CN")).toBe("图书馆");
  expect(stopName(stops[2]!, "en")).toBe("东门");
  expect(stopNameById(stops, "gone", "en")).toBe("gone");
});

test("stops are found by terms of either language", () => {
  const found = (query: string) => searchStops(stops, query).map((stop) => stop.stop_id);
  expect(found("library main")).toEqual(["stop-1"]);
  expect(found("体育")).toEqual(["stop-2"]);
  expect(found("  ")).toEqual(["stop-1", "stop-2", "stop-3"]);
  expect(found("harbour")).toEqual([]);
});
