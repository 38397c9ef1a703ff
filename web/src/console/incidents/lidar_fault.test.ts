import { expect, test } from "vitest";
import { lidarFault } from "./lidar_fault";

test("a cause names the lidar after the code", () => {
  expect(lidarFault("lidar_moved (front_left)")).toEqual({
    code: "lidar_moved",
    lidar: "front_left",
  });
});

test("a name with brackets and commas stays whole", () => {
  expect(lidarFault("lidar_silent (rear (old), left)")?.lidar).toBe("rear (old), left");
});

test("an older shuttle names none, and other causes are not of lidars", () => {
  for (const cause of ["lidar_blind", "pose_poor", "stop (at NN20)", "lidar_moved ()", ""])
    expect(lidarFault(cause)).toBeNull();
});
