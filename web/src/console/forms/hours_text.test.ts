import { expect, test } from "vitest";
import { hoursFrom, hoursText } from "./hours_text";

test("hours and their text are each other's inverse", () => {
  const hours = [
    { opens: "07:30", closes: "12:00" },
    { opens: "13:30", closes: "25:00" },
  ];
  expect(hoursFrom(hoursText(hours))).toEqual(hours);
  expect(hoursFrom(" 07:30 - 12:00 ,")).toEqual([hours[0]]);
  expect(hoursFrom("")).toEqual([]);
});
