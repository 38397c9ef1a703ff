import { expect, test } from "vitest";
import { Motion, wrapAngle } from "./pose_interpolation";
import { aScene, aVehicle } from "./scene_builders";

function sceneWith(x_m: number, yaw_rad = 0) {
  return aScene({ vehicles: [aVehicle({ x_m, yaw_rad })] });
}

test("a shuttle glides to its newest pose in the time between its last two reports", () => {
  const motion = new Motion();
  motion.accept(sceneWith(0), 0, false);
  motion.accept(sceneWith(1), 200, false);
  expect(motion.pose(aVehicle(), 300).x_m).toBeCloseTo(0.5);
  expect(motion.isMoving(300)).toBe(true);
  expect(motion.pose(aVehicle(), 900).x_m).toBe(1);
  expect(motion.isMoving(900)).toBe(false);
});

test("it turns the short way round", () => {
  const motion = new Motion();
  motion.accept(sceneWith(0, 3), 0, false);
  motion.accept(sceneWith(0, -3), 200, false);
  expect(Math.abs(wrapAngle(motion.pose(aVehicle(), 300).yaw_rad))).toBeCloseTo(Math.PI);
});

test("a report from far away is a jump, not a drive", () => {
  const motion = new Motion();
  motion.accept(sceneWith(0), 0, false);
  motion.accept(sceneWith(500), 200, false);
  expect(motion.pose(aVehicle(), 201).x_m).toBe(500);
});

test("people who prefer stillness see no gliding", () => {
  const motion = new Motion();
  motion.accept(sceneWith(0), 0, true);
  motion.accept(sceneWith(1), 200, true);
  expect(motion.pose(aVehicle(), 201).x_m).toBe(1);
  expect(motion.isMoving(201)).toBe(false);
});

test("angles are wrapped into (-pi, pi]", () => {
  expect(wrapAngle(3 * Math.PI)).toBeCloseTo(Math.PI);
  expect(wrapAngle(-Math.PI)).toBeCloseTo(Math.PI);
  expect(wrapAngle(-1.5 * Math.PI)).toBeCloseTo(0.5 * Math.PI);
});
