import { expect, test } from "vitest";
import { routeAhead } from "./route_ahead";

const corner = [
  [0, 0],
  [10, 0],
  [10, 10],
] as const;

test("the part behind the shuttle is cut off", () => {
  expect(routeAhead(corner, 4, 1)).toEqual([
    [4, 0],
    [10, 0],
    [10, 10],
  ]);
});

test("at the end only the end is left", () => {
  expect(routeAhead(corner, 10, 12)).toEqual([
    [10, 10],
    [10, 10],
  ]);
});

test("a route without length stays as it is", () => {
  expect(routeAhead([], 1, 1)).toEqual([]);
  expect(routeAhead([[2, 2]], 1, 1)).toEqual([[2, 2]]);
});

test("where the route comes by twice, its first pass counts", () => {
  const there_and_back = [
    [0, 0],
    [10, 0],
    [0, 0],
  ] as const;
  expect(routeAhead(there_and_back, 4, 0)).toEqual([
    [4, 0],
    [10, 0],
    [0, 0],
  ]);
});
