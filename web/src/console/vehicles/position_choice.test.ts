import { expect, test } from "vitest";
import { afterClick, poseOf, type PositionChoice } from "./position_choice";

const BEGUN: PositionChoice = { vehicle_id: "shuttle-1", at: null, towards: null };

test("the first click is the place, the second the direction", () => {
  const placed = afterClick(BEGUN, [10, 20]);
  expect(poseOf(placed)).toBeNull();
  const turned = afterClick(placed, [10, 25]);
  expect(poseOf(turned)).toEqual({ x_m: 10, y_m: 20, yaw_rad: Math.PI / 2 });
});

test("a third click begins again at another place", () => {
  const turned = afterClick(afterClick(BEGUN, [10, 20]), [0, 20]);
  expect(poseOf(turned)?.yaw_rad).toBeCloseTo(Math.PI);
  const again = afterClick(turned, [30, 40]);
  expect(again.at).toEqual([30, 40]);
  expect(poseOf(again)).toBeNull();
});
