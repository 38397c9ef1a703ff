import { expect, test } from "vitest";
import { BoxGrid } from "./box_grid";

test("a box is taken by whatever overlaps it, in any cell, but not by itself", () => {
  const grid = new BoxGrid();
  const wide = { left: -10, top: 10, right: 300, bottom: 20 };
  grid.add(wide);
  expect(grid.isTaken({ left: 280, top: 0, right: 290, bottom: 11 })).toBe(true);
  expect(grid.isTaken({ left: 280, top: 20, right: 290, bottom: 30 })).toBe(false);
  expect(grid.isTaken({ left: -30, top: 12, right: -9, bottom: 15 })).toBe(true);
  expect(grid.isTaken(wide, wide)).toBe(false);
});
