import { expect, test } from "vitest";
import { formatHours, parseHours } from "./hours_text";

test("hours and their text are each other's inverse", () => {
  const hours = [
    { opens: "07:30", closes: "12:00" },
    { opens: "13:30", closes: "25:00" },
  ];
  expect(parseHours(formatHours(hours))).toEqual(hours);
  expect(parseHours(" 07:30 - 12:00 ,")).toEqual([hours[0]]);
  expect(parseHours("")).toEqual([]);
});
