import { expect, test } from "vitest";
import type { Camera } from "./camera";
import { boundsOf, fitCamera, panCamera, toMap, toScreen, zoomCamera } from "./camera";

const size = { width_px: 400, height_px: 300 };
const camera: Camera = { x_m: 120, y_m: -40, px_per_m: 0.7 };

test("screen and map are each other's inverse, and north is up", () => {
  const [x_px, y_px] = toScreen(camera, size, 150, -10);
  const [x_m, y_m] = toMap(camera, size, x_px, y_px);
  expect(x_m).toBeCloseTo(150);
  expect(y_m).toBeCloseTo(-10);
  expect(y_px).toBeLessThan(toScreen(camera, size, 150, -20)[1]);
});

test("zooming keeps the point under the finger", () => {
  const before = toMap(camera, size, 30, 200);
  const after = toMap(zoomCamera(camera, size, 30, 200, 1.9), size, 30, 200);
  expect(after[0]).toBeCloseTo(before[0]);
  expect(after[1]).toBeCloseTo(before[1]);
});

test("zoom is limited in both directions", () => {
  expect(zoomCamera(camera, size, 0, 0, 1e9).px_per_m).toBe(24);
  expect(zoomCamera(camera, size, 0, 0, 1e-9).px_per_m).toBe(0.02);
});

test("panning moves the map with the finger", () => {
  const [x_px, y_px] = toScreen(panCamera(camera, 12, -7), size, 150, -10);
  const [x0_px, y0_px] = toScreen(camera, size, 150, -10);
  expect([x_px - x0_px, y_px - y0_px]).toEqual([expect.closeTo(12), expect.closeTo(-7)]);
});

test("fitting shows all points inside the padding, and touches it on two sides", () => {
  const bounds = boundsOf([
    [0, 0],
    [1000, 200],
    [300, -100],
  ])!;
  const padding = { top: 10, right: 60, bottom: 20, left: 30 };
  const seen = fitCamera(bounds, size, padding);
  const [left, bottom] = toScreen(seen, size, bounds.x_min_m, bounds.y_min_m);
  const [right, top] = toScreen(seen, size, bounds.x_max_m, bounds.y_max_m);
  expect(left).toBeCloseTo(30);
  expect(right).toBeCloseTo(340);
  expect(top).toBeGreaterThanOrEqual(10);
  expect(bottom).toBeLessThanOrEqual(280);
  expect((top - 10 + (bottom - 280)) / 2).toBeCloseTo(0);
});

test("no points have no bounds", () => {
  expect(boundsOf([])).toBeNull();
});
