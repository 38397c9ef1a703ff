import { expect, test } from "vitest";
import { lateMinutes } from "./promises";

test.each([
  [null, 0],
  ["2026-09-01T08:29:00Z", 0],
  ["2026-09-01T08:30:00Z", 0],
  ["2026-09-01T08:30:10Z", 1],
  ["2026-09-01T08:34:00Z", 4],
])("expected at %s against 08:30 is %i minutes late", (expected, minutes) => {
  expect(lateMinutes(expected, "2026-09-01T08:30:00Z")).toBe(minutes);
});
