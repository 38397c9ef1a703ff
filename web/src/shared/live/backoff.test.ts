import { expect, test } from "vitest";
import { retryDelay_ms } from "./backoff";

test("every attempt waits longer, up to 15 s", () => {
  const delays = [0, 1, 2, 3, 4, 5, 50].map((attempt) => retryDelay_ms(attempt, 1));
  expect(delays).toEqual([500, 1000, 2000, 4000, 8000, 15_000, 15_000]);
});

test("phones that lost the same server reconnect at different times", () => {
  expect(retryDelay_ms(3, 0)).toBe(2000);
  expect(retryDelay_ms(3, 0.5)).toBe(3000);
});
