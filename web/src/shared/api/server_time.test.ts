import { beforeEach, expect, test } from "vitest";
import { forgetServerTime, noteSent, serverNow_ms } from "./server_time";

const NOW_MS = Date.parse("2026-11-26T08:00:00Z");
const HOUR_MS = 3_600_000;

beforeEach(forgetServerTime);

test("without an answer it is the device's own", () => {
  expect(serverNow_ms(NOW_MS)).toBe(NOW_MS);
});

test("a clock that is an hour behind or ahead is put right", () => {
  noteSent("Thu, 26 Nov 2026 09:00:00 GMT", NOW_MS);
  expect(serverNow_ms(NOW_MS)).toBe(NOW_MS + HOUR_MS);
  forgetServerTime();
  noteSent("Thu, 26 Nov 2026 07:00:00 GMT", NOW_MS);
  expect(serverNow_ms(NOW_MS + 1_000)).toBe(NOW_MS + 1_000 - HOUR_MS);
});

test("an answer that was kept since yesterday does not turn the clock back", () => {
  noteSent("Thu, 26 Nov 2026 09:00:00 GMT", NOW_MS);
  noteSent("Wed, 25 Nov 2026 08:00:00 GMT", NOW_MS + 1_000);
  expect(serverNow_ms(NOW_MS)).toBe(NOW_MS + HOUR_MS);
});

test("seconds of an answer's way are no difference, and a header that is none is left out", () => {
  noteSent("Thu, 26 Nov 2026 07:59:57 GMT", NOW_MS);
  noteSent(null, NOW_MS);
  noteSent("soon", NOW_MS);
  expect(serverNow_ms(NOW_MS)).toBe(NOW_MS);
});
