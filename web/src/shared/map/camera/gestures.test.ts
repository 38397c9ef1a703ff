import { expect, test } from "vitest";
import { cameraAfterKey } from "./gestures";

const size = { width_px: 400, height_px: 300 };
const camera = { x_m: 0, y_m: 0, px_per_m: 2 };

test("arrow keys pan, plus and minus zoom, other keys do nothing", () => {
  expect(cameraAfterKey("ArrowRight", camera, size)!.x_m).toBeGreaterThan(0);
  expect(cameraAfterKey("ArrowUp", camera, size)!.y_m).toBeGreaterThan(0);
  expect(cameraAfterKey("+", camera, size)!.px_per_m).toBeGreaterThan(2);
  expect(cameraAfterKey("-", camera, size)!.px_per_m).toBeLessThan(2);
  expect(cameraAfterKey("a", camera, size)).toBeNull();
});
