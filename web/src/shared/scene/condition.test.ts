import { expect, test } from "vitest";
import type { Condition } from "./condition";
import { conditionOf } from "./condition";
import { aVehicle, type VehicleChanges } from "./scene_builders";

const cases: readonly (readonly [Condition, VehicleChanges])[] = [
  ["driving", {}],
  ["standing", { speed_mps: 0 }],
  ["charging", { speed_mps: 0, at_charger: true }],
  ["standing", { speed_mps: 0, at_charger: true, battery_ratio: 1 }],
  ["driving", { at_charger: true }],
  ["boarding", { speed_mps: 0, doors_open: true }],
  ["blocked", { speed_mps: 0, obstacle_m: 3 }],
  ["standing", { speed_mps: 0, obstacle_m: 40 }],
  ["waiting", { speed_mps: 0, waiting_for: "lane-7/2", obstacle_m: 3 }],
  ["held", { held: true }],
  ["held", { mode: "held" }],
  ["manual", { mode: "manual", held: true }],
  ["minimal_risk", { mode: "minimal_risk", held: true }],
  ["fault", { mode: "fault", held: true }],
  ["offline", { connected: false, mode: "fault" }],
];

test.each(cases)("a shuttle is %s when %o", (condition, changes) => {
  expect(conditionOf(aVehicle(changes))).toBe(condition);
});
