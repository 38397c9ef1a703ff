import { expect, test } from "vitest";
import { aDrivingView, aScene, aVehicle } from "../../shared/scene/scene_builders";
import type { VehicleChanges } from "../../shared/scene/scene_builders";
import { BUCKETS, markedBuckets, marksOfScenes, nextMark } from "./marks";

function scenes(...changes: VehicleChanges[]) {
  return changes.map((change, k) => aScene({ at_ms: 1000 * k, vehicles: [aVehicle(change)] }));
}

function kinds(...changes: VehicleChanges[]) {
  return marksOfScenes(scenes(...changes)).map((mark) => [mark.at_ms, mark.kind]);
}

test("a stop is marked when the doors open, once", () => {
  const open = { doors_open: true, next_stop: "gate" };
  expect(kinds({}, open, open, {}, open)).toEqual([
    [1000, "stop"],
    [4000, "stop"],
  ]);
  expect(marksOfScenes(scenes({}, open))[0]!.stop_id).toBe("gate");
});

test("a takeover and a minimal-risk stop are marked where they begin, not at the start of a run", () => {
  expect(kinds({ mode: "manual" }, {}, { mode: "manual" }, { mode: "minimal_risk" })).toEqual([
    [2000, "takeover"],
    [3000, "minimal_risk_stop"],
  ]);
});

test("one hard braking is one mark, however long it takes", () => {
  const hard = { accel_mps2: -3 };
  expect(kinds(hard, hard, {}, hard, {}, {}, {}, hard, { accel_mps2: -1.5 })).toEqual([
    [0, "braking"],
    [7000, "braking"],
  ]);
});

test("a hard braking tells who brakes", () => {
  const brake = (change: VehicleChanges) => ({ accel_mps2: -3, ...change });
  const who = (change: VehicleChanges) => marksOfScenes(scenes(brake(change)))[0]?.detail;
  const driving = (guard: string) => ({ driving: aDrivingView({ guard }) });
  expect(who({})).toBe("braking_by_planner");
  expect(who(driving("emergency"))).toBe("braking_by_planner");
  expect(who(driving("obstacle"))).toBe("braking_by_guard");
  expect(who({ mode: "manual" })).toBe("braking_by_driver");
  const fault = {
    code: "gate_braking_footprint",
    severity: "stop",
    since_ns: 0,
    detail: "",
  } as const;
  expect(who({ faults: [fault] })).toBe("braking_by_gate");
});

test("the guard's stop for a contact is marked, however gently it brakes", () => {
  const stop = { accel_mps2: -0.5, driving: aDrivingView({ guard: "obstacle" }) };
  const slow = { accel_mps2: -0.5, driving: aDrivingView({ guard: "somebody alongside" }) };
  expect(kinds({}, stop, stop, {}, slow)).toEqual([[1000, "braking"]]);
});

test("a fault is marked when it comes, with its code", () => {
  const fault = { code: "lidar_blind", severity: "stop", since_ns: 0, detail: "" } as const;
  expect(kinds({}, { faults: [fault] }, { faults: [fault] }, {}, { faults: [fault] })).toEqual([
    [1000, "fault"],
    [4000, "fault"],
  ]);
});

test("next and previous mark leave out the one of this moment", () => {
  const marks = marksOfScenes(scenes({ accel_mps2: -3 }, {}, {}, {}, { accel_mps2: -3 }));
  expect(nextMark(marks, 0, 1)?.at_ms).toBe(4000);
  expect(nextMark(marks, 4000, 1)).toBeUndefined();
  expect(nextMark(marks, 4000, -1)?.at_ms).toBe(0);
  expect(nextMark(marks, 0, -1)).toBeUndefined();
});

test("thousands of marks take no more places than the timeline has", () => {
  const stop = {
    kind: "stop",
    vehicle_id: "",
    stop_id: "",
    ride_id: "",
    detail: "",
    by: "",
    text: "",
  } as const;
  const marks = Array.from({ length: 20_000 }, (_, k) => ({ ...stop, at_ms: k }));
  const rows = markedBuckets(marks, 0, 19_999);
  expect(rows.map((row) => row.length)).toEqual([0, 0, BUCKETS + 1]);
});

test("marks outside of what is shown are left out", () => {
  const stop = {
    kind: "stop",
    vehicle_id: "",
    stop_id: "",
    ride_id: "",
    detail: "",
    by: "",
    text: "",
  } as const;
  expect(markedBuckets([{ ...stop, at_ms: 5 }], 10, 20)).toEqual([[], [], []]);
});
