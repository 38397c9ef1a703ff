import { expect, test } from "vitest";
import type { Elements, Lane } from "./drawing";
import { NOTHING, changeBetween, lengthOf_m, withoutElement } from "./drawing";
import {
  PULL_REACH_M,
  drawnLane,
  kerbPulled,
  pulled,
  split,
  stopMoved,
  withCrossing,
  withKerb,
  withStop,
  withZone,
} from "./edits";
import { ElementDrag } from "./dragging";
import { EditorState } from "./editor_state";
import { elementAt } from "./hit";

function straight(lane_id: string, from_m: number, to_m: number, ...successors: string[]): Lane {
  const points: [number, number][] = [];
  for (let x = from_m; x <= to_m; x++) points.push([x, 0]);
  return {
    lane_id,
    kind: "road",
    points,
    width_m: 4,
    speed_limit_mps: 4,
    can_pass: false,
    successors,
    scenario: "common_road",
    name: "",
    name_en: "",
  };
}

const ROAD: Elements = {
  ...NOTHING,
  lanes: [straight("a", 0, 100, "b"), straight("b", 100, 160)],
  stops: [
    { stop_id: "s", name: "S", lane_id: "a", s_m: 70, name_en: "", placed_by: "hand" },
    { stop_id: "t", name: "T", lane_id: "a", s_m: 20, name_en: "", placed_by: "hand" },
  ],
  no_stopping_zones: [{ zone_id: "z", lane_id: "a", s_from_m: 60, s_to_m: 80 }],
};

const lane = (elements: Elements, lane_id: string) =>
  elements.lanes.find((one) => one.lane_id === lane_id)!;

test("a pulled lane goes through the place, and only near it", () => {
  const next = lane(pulled(ROAD, "a", [50, 1], [50, 4]), "a");
  expect(next.points[50]).toEqual([50, 4]);
  expect(next.points[50 + PULL_REACH_M]).toEqual([65, 0]);
  expect([next.points[0], next.points.at(-1)]).toEqual([
    [0, 0],
    [100, 0],
  ]);
});

test("a lane pulled near its end keeps the end where the next one begins", () => {
  const next = lane(pulled(ROAD, "a", [96, 0], [96, 2]), "a");
  expect(next.points[96]).toEqual([96, 2]);
  expect(next.points.at(-1)).toEqual([100, 0]);
});

test("a drawn lane is joined to the ends that are near its own", () => {
  const { elements, lane_id } = drawnLane(ROAD, [
    [159, 1],
    [150, 40],
    [1, 1],
  ]);
  const drawn = lane(elements, lane_id);
  expect(drawn.points[0]).toEqual([160, 0]);
  expect(drawn.points.at(-1)).toEqual([0, 0]);
  expect(lane(elements, "b").successors).toEqual([lane_id]);
  expect(drawn.successors).toEqual(["a"]);
});

test("a split lane keeps its length, and its stops their places", () => {
  const next = split(ROAD, "a", [50, 0]);
  expect(next.lanes.map((one) => one.lane_id)).toEqual(["a", "a-1", "b"]);
  expect(lane(next, "a").successors).toEqual(["a-1"]);
  expect(lane(next, "a-1").successors).toEqual(["b"]);
  const halves = ["a", "a-1"].map((id) => lengthOf_m(lane(next, id).points));
  expect(halves).toEqual([50, 50]);
  expect(next.stops.map((stop) => [stop.lane_id, stop.s_m])).toEqual([
    ["a-1", 20],
    ["a", 20],
  ]);
  expect(next.no_stopping_zones).toEqual([
    { zone_id: "z", lane_id: "a-1", s_from_m: 10, s_to_m: 30 },
  ]);
});

test("stops, zones and crossings lie on the lane that is nearest", () => {
  expect(withStop(ROAD, [130, 2], "New").stops.at(-1)).toMatchObject({ lane_id: "b", s_m: 30 });
  expect(stopMoved(ROAD, "s", [10, -1]).stops[0]).toMatchObject({ lane_id: "a", s_m: 10 });
  expect(withZone(ROAD, [150, 0], [120, 0]).no_stopping_zones.at(-1)).toMatchObject({
    lane_id: "b",
    s_from_m: 20,
    s_to_m: 50,
  });
  const crossing = withCrossing(ROAD, [40, 0]).observation_areas[0]!;
  expect(crossing.stop_lines).toEqual([["a", 37.5]]);
  expect(crossing.outline[0]).toEqual([38, -4]);
});

test("without a lane, what lay on it and what led to it are gone", () => {
  const next = withoutElement(ROAD, "lanes", "a");
  expect(next.stops).toEqual([]);
  expect(next.no_stopping_zones).toEqual([]);
  expect(lane(withoutElement(ROAD, "lanes", "b"), "a").successors).toEqual([]);
});

test("a change names what is new and what is gone, and nothing else", () => {
  const moved = stopMoved(ROAD, "s", [10, 0]);
  expect(changeBetween(ROAD, moved)).toEqual({ put: { stops: [moved.stops[0]] }, removed: {} });
  expect(changeBetween(moved, withoutElement(moved, "stops", "t"))).toEqual({
    put: {},
    removed: { stops: ["t"] },
  });
  expect(changeBetween(ROAD, ROAD)).toEqual({ put: {}, removed: {} });
});

test("a tap means the smallest thing there", () => {
  expect(elementAt(ROAD, [70, 0.5], 3)).toEqual({ kind: "stops", id: "s" });
  expect(elementAt(ROAD, [62, 0.5], 3)).toEqual({ kind: "no_stopping_zones", id: "z" });
  expect(elementAt(ROAD, [40, 0.5], 3)).toEqual({ kind: "lanes", id: "a" });
  expect(elementAt(ROAD, [40, 50], 3)).toBeNull();
});

test("a kerb's nearest point is pulled, and the others stay", () => {
  const drawn = withKerb(NOTHING, [
    [0, 5],
    [10, 5],
    [20, 5],
  ]);
  const next = kerbPulled(drawn, "kerb-1", [10.2, 5.1], [10.2, 7.1]);
  expect(next.kerbs[0]!.points).toEqual([
    [0, 5],
    [10, 7],
    [20, 5],
  ]);
});

test("what is dragged is only shown until it is put down, and is one step then", () => {
  const state = new EditorState("d");
  state.elements.value = ROAD;
  const drag = new ElementDrag(state);
  expect(drag.grab([150, 30], 2)).toBe(false);
  expect(drag.grab([70, 0.5], 2)).toBe(true);
  drag.drag([40, 1]);
  drag.drag([30, 1]);
  expect(state.elements.value).toBe(ROAD);
  expect(state.preview.value!.stops[0]!.s_m).toBe(30);
  drag.drop();
  expect(state.elements.value.stops[0]!.s_m).toBe(30);
  expect(state.preview.value).toBeNull();
  state.undo();
  expect(state.elements.value).toBe(ROAD);
});

test("what is let go goes back", () => {
  const state = new EditorState("d");
  state.elements.value = ROAD;
  const drag = new ElementDrag(state);
  drag.grab([50, 0], 2);
  drag.drag([50, 6]);
  expect(lane(state.preview.value!, "a").points[50]).toEqual([50, 6]);
  drag.letGo();
  drag.drop();
  expect(state.elements.value).toBe(ROAD);
  expect(state.can_undo.value).toBe(false);
});
