import { expect, test } from "vitest";
import { clockSeconds, clockTime, fromLocalInput, momentNear, toLocalInput } from "./times";

const moment = Date.UTC(2026, 8, 1, 16, 5, 9);

test("times are told on the campus's clocks, whatever the phone's zone", () => {
  expect(clockTime(moment, "en", "Asia/Shanghai")).toBe("00:05");
  expect(clockSeconds(moment, "zh-CN", "Asia/Shanghai")).toBe("00:05:09");
  expect(clockTime(moment, "en", "America/Chicago")).toBe("11:05");
});

test("another day is named with the time", () => {
  const hour_ms = 3_600_000;
  expect(momentNear(moment, moment + hour_ms, "en", "Asia/Shanghai")).toBe("00:05");
  expect(momentNear(moment, moment - hour_ms, "en", "Asia/Shanghai")).toContain("Wed");
});

test.each(["Asia/Shanghai", "America/Chicago", "Asia/Kolkata", "UTC"])(
  "an input's text and its moment are each other's inverse in %s",
  (timezone) => {
    const text = toLocalInput(moment, timezone);
    expect(fromLocalInput(text, timezone)!.getTime()).toBe(moment - 9_000);
  },
);

test("a change of the clocks is counted", () => {
  const after = fromLocalInput("2026-03-08T03:30", "America/Chicago")!;
  expect(after.toISOString()).toBe("2026-03-08T08:30:00.000Z");
});

test("what is no time gives nothing", () => {
  expect(fromLocalInput("tomorrow", "UTC")).toBeNull();
});
