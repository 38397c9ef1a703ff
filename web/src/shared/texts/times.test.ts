import { expect, test } from "vitest";
import {
  formatTime,
  formatTimeOrDateTime,
  formatTimeWithSeconds,
  fromLocalInput,
  toLocalInput,
} from "./times";

const time_ms = Date.UTC(2026, 8, 1, 16, 5, 9);

test("times are in the campus's timezone", () => {
  expect(formatTime(time_ms, "en", "Asia/Shanghai")).toBe("00:05");
  expect(formatTimeWithSeconds(time_ms, "zh-CN", "Asia/Shanghai")).toBe("00:05:09");
  expect(formatTime(time_ms, "en", "America/Chicago")).toBe("11:05");
});

test("a time on another day has its date", () => {
  const hour_ms = 3_600_000;
  expect(formatTimeOrDateTime(time_ms, time_ms + hour_ms, "en", "Asia/Shanghai")).toBe("00:05");
  expect(formatTimeOrDateTime(time_ms, time_ms - hour_ms, "en", "Asia/Shanghai")).toContain("Wed");
});

test.each(["Asia/Shanghai", "America/Chicago", "Asia/Kolkata", "UTC"])(
  "an input's text and its time are each other's inverse in %s",
  (timezone) => {
    const text = toLocalInput(time_ms, timezone);
    expect(fromLocalInput(text, timezone)!.getTime()).toBe(time_ms - 9_000);
  },
);

test("the change to summer time is counted", () => {
  const after = fromLocalInput("2026-03-08T03:30", "America/Chicago")!;
  expect(after.toISOString()).toBe("2026-03-08T08:30:00.000Z");
});

test("a text that is no time gives null", () => {
  expect(fromLocalInput("tomorrow", "UTC")).toBeNull();
});
