import { expect, test } from "vitest";
import {
  arrowOf,
  barbsOf,
  cornersOf,
  kindOf,
  heightBand,
  scanPoints,
  type ShownTrack,
  signOutline,
  speedOf,
} from "./seen_things";

/** A car that looks north and drives there at 5 m/s. */
const CAR: ShownTrack = [12, "vehicle", 10, 20, Math.PI / 2, 4, 2, 0, 5, false];

function rounded(points: readonly (readonly [number, number])[]) {
  return points.map(([x, y]) => [Math.round(100 * x) / 100, Math.round(100 * y) / 100]);
}

test("an outline lies along its heading", () => {
  expect(rounded(cornersOf(CAR, 0))).toEqual([
    [9, 22],
    [9, 18],
    [11, 18],
    [11, 22],
  ]);
});

test("what would be too small to see is drawn larger, about its middle", () => {
  expect(rounded(cornersOf(CAR, 8))).toEqual([
    [6, 24],
    [6, 16],
    [14, 16],
    [14, 24],
  ]);
});

test("an arrow shows the next second, and what stands has none", () => {
  expect(arrowOf(CAR)).toEqual([
    [10, 20],
    [10, 25],
  ]);
  expect(speedOf(CAR)).toBe(5);
  const standing: ShownTrack = [1, "vehicle", 0, 0, 0, 4, 2, 0.1, -0.1, false];
  expect(arrowOf(standing)).toBeNull();
});

test("barbs lie behind the arrow's tip, one at each side", () => {
  const [left, right] = barbsOf(arrowOf(CAR)!, 1);
  expect(left[1]).toBeLessThan(25);
  expect(left[1]).toBeCloseTo(right[1]);
  expect(left[0] - 10).toBeCloseTo(10 - right[0]);
});

test("a kind that this page does not know is another object", () => {
  expect(kindOf(CAR)).toBe("vehicle");
  expect(kindOf([1, "animal", 0, 0, 0, 1, 1, 0, 0, false])).toBe("other");
});

test("signs are told by their shape: octagon flat on top, triangle on its tip, square", () => {
  const stop = signOutline("stop", 10);
  expect(stop).toHaveLength(8);
  const top = Math.min(...stop.map(([, y]) => y));
  expect(stop.filter(([, y]) => Math.abs(y - top) < 1e-9)).toHaveLength(2);
  const tip = signOutline("yield", 10);
  expect(rounded(tip)[0]).toEqual([0, 10]);
  expect(tip.filter(([, y]) => y < 0)).toHaveLength(2);
  expect(signOutline("board", 10)).toHaveLength(4);
});

test("points of a scan come back where they were, to the centimetre; what is cut off is left out", () => {
  const numbers = new DataView(new ArrayBuffer(14));
  [150, -225, 80, -3000, 1, 32_000, 7].forEach((cm, k) => numbers.setInt16(2 * k, cm, true));
  const offsets_cm = btoa(String.fromCharCode(...new Uint8Array(numbers.buffer)));
  const points = scanPoints({ x_m: 100, y_m: 50, age_s: 0, offsets_cm });
  expect([...points].map((value) => Math.round(100 * value) / 100)).toEqual([
    101.5, 47.75, 0.8, 70, 50.01, 320,
  ]);
});

test("points are in three bands: kerbs, people, and what is higher", () => {
  expect([-0.2, 0.49, 0.5, 1.99, 2, 9].map(heightBand)).toEqual([0, 0, 1, 1, 2, 2]);
});
