import { expect, test } from "vitest";
import { dayAfter, dayOf, startOfDay_ms } from "./campus_day";

test.each([
  ["2026-11-25", "Asia/Shanghai", "2026-11-24T16:00:00Z", 24],
  ["2026-10-25", "Europe/Berlin", "2026-10-24T22:00:00Z", 25],
  ["2026-03-29", "Europe/Berlin", "2026-03-28T23:00:00Z", 23],
  ["2026-11-01", "America/Los_Angeles", "2026-11-01T07:00:00Z", 25],
  ["2026-06-30", "UTC", "2026-06-30T00:00:00Z", 24],
])("%s in %s begins at %s and has %i hours", (date, timezone, start, hours) => {
  const start_ms = startOfDay_ms(date, timezone);
  expect(new Date(start_ms).toISOString()).toBe(new Date(start).toISOString());
  expect(startOfDay_ms(dayAfter(date), timezone) - start_ms).toBe(hours * 3_600_000);
  expect(dayOf(start_ms, timezone)).toBe(date);
  expect(dayOf(start_ms - 1, timezone)).not.toBe(date);
});
