import { expect, test } from "vitest";
import { dayBounds } from "./campus_day";

test("a day begins at the campus's midnight", () => {
  expect(dayBounds("2026-11-25", "Asia/Shanghai")).toEqual({
    since: "2026-11-24T16:00:00.000Z",
    before: "2026-11-25T16:00:00.000Z",
  });
});

test("the day on which the clocks go back has 25 hours", () => {
  const { since, before } = dayBounds("2026-10-25", "Europe/Berlin");
  expect(since).toBe("2026-10-24T22:00:00.000Z");
  expect(before).toBe("2026-10-25T23:00:00.000Z");
});
