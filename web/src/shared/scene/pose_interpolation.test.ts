import { expect, test } from "vitest";
import { PoseInterpolator, wrapAngle } from "./pose_interpolation";
import { aScene, aVehicle } from "./scene_builders";

function sceneWith(x_m: number, yaw_rad = 0) {
  return aScene({ vehicles: [aVehicle({ pose_map: [x_m, 0, yaw_rad] })] });
}

test("a shuttle moves to its newest pose in the time between its last two reports", () => {
  const poses = new PoseInterpolator();
  poses.update(sceneWith(0), 0, true);
  poses.update(sceneWith(1), 200, true);
  expect(poses.pose(aVehicle(), 300)!.x_m).toBeCloseTo(0.5);
  expect(poses.isMoving(300)).toBe(true);
  expect(poses.pose(aVehicle(), 900)!.x_m).toBe(1);
  expect(poses.isMoving(900)).toBe(false);
});

test("it turns by the smaller angle", () => {
  const poses = new PoseInterpolator();
  poses.update(sceneWith(0, 3), 0, true);
  poses.update(sceneWith(0, -3), 200, true);
  expect(Math.abs(wrapAngle(poses.pose(aVehicle(), 300)!.yaw_rad))).toBeCloseTo(Math.PI);
});

test("a report from far away is a jump, not a drive", () => {
  const poses = new PoseInterpolator();
  poses.update(sceneWith(0), 0, true);
  poses.update(sceneWith(500), 200, true);
  expect(poses.pose(aVehicle(), 201)!.x_m).toBe(500);
});

test("without interpolation a shuttle jumps to its newest pose", () => {
  const poses = new PoseInterpolator();
  poses.update(sceneWith(0), 0, false);
  poses.update(sceneWith(1), 200, false);
  expect(poses.pose(aVehicle(), 201)!.x_m).toBe(1);
  expect(poses.isMoving(201)).toBe(false);
});

test("the noise of a standing shuttle moves nothing, and a slow drift shows in the end", () => {
  const poses = new PoseInterpolator();
  expect(poses.update(sceneWith(0), 0, true)).toBe(true);
  expect(poses.update(sceneWith(0.03, 0.01), 200, true)).toBe(false);
  expect(poses.update(sceneWith(-0.04, -0.01), 400, true)).toBe(false);
  expect(poses.isMoving(450)).toBe(false);
  expect(poses.update(sceneWith(0.12), 600, true)).toBe(true);
  expect(poses.isMoving(650)).toBe(true);
  expect(poses.update(aScene({ vehicles: [] }), 800, true)).toBe(true);
});

test("angles are wrapped into (-pi, pi]", () => {
  expect(wrapAngle(3 * Math.PI)).toBeCloseTo(Math.PI);
  expect(wrapAngle(-Math.PI)).toBeCloseTo(Math.PI);
  expect(wrapAngle(-1.5 * Math.PI)).toBeCloseTo(0.5 * Math.PI);
});
