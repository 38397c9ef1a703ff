import { expect, test } from "vitest";
import { delayMinutes } from "./delay";

test.each([
  [0, 0],
  [29, 0],
  [-29, 0],
  [31, 1],
  [-31, -1],
  [190, 3],
  [-600, -10],
])("%i seconds later are %i minutes", (later_s, minutes) => {
  expect(delayMinutes(later_s)).toBe(minutes);
});
