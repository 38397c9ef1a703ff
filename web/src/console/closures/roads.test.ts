import { expect, test } from "vitest";
import type { Lane } from "./roads";
import { length_m, oppositeLanes, roadAt, roadName } from "./roads";

function aLane(lane_id: string, points: Lane["points"], changes: Partial<Lane> = {}): Lane {
  return { lane_id, kind: "road", name: "", name_en: "", points, width_m: 4, ...changes };
}

const there = aLane("there", [
  [0, 0],
  [100, 0],
]);
const back = aLane("back", [
  [100, 3],
  [0, 3],
]);
const turn = aLane(
  "turn",
  [
    [100, 0],
    [104, 4],
  ],
  { kind: "turn" },
);
const lanes = [there, back, turn];
const stops = [
  {
    stop_id: "s",
    name: "图书馆",
    name_en: "Library",
    lane_id: "there",
    s_m: 1,
    x_m: 9,
    y_m: 9,
    placed_by: "tag",
  },
];

test("the road at a place is the nearest one within reach, and no turn", () => {
  expect(roadAt(lanes, [50, 1], 3)).toBe(there);
  expect(roadAt(lanes, [50, 2.8], 3)).toBe(back);
  expect(roadAt(lanes, [50, 40], 3)).toBeNull();
  expect(roadAt(lanes, [104, 4], 1)).toBeNull();
});

test("the opposite direction has the same ends the other way round", () => {
  expect(oppositeLanes(lanes, there)).toEqual([back]);
  expect(oppositeLanes([there, turn], there)).toEqual([]);
});

test("a road without a name is named by the stop nearest to it", () => {
  const near = (stop: string) => `near ${stop}`;
  expect(roadName(there, stops, "en", near)).toBe("near Library");
  expect(roadName({ ...there, name: "南路" }, stops, "en", near)).toBe("南路");
  expect(length_m(there)).toBe(100);
});
