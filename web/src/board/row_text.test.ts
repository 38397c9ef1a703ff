import { expect, test } from "vitest";
import { rangeText } from "./row_text";
import { en } from "./texts/texts_en";

const NOW = Date.parse("2026-11-23T08:00:00Z");
const at = { now_ms: NOW, language: "en", timezone: "UTC" } as const;
const range = (from_s: number, to_s: number) => ({
  earliest: new Date(NOW + from_s * 1000).toISOString(),
  latest: new Date(NOW + to_s * 1000).toISOString(),
});

test.each([
  [range(-20, 40), "Any moment"],
  [range(30, 150), "0–3 min"],
  [range(180, 180), "3 min"],
  [range(170, 300), "2–5 min"],
  [range(1_800, 2_100), "30–35 min"],
  [range(2_000, 2_400), "08:33–08:40"],
])("%o is told as %s", (given, text) => {
  expect(rangeText(given, at, en)).toBe(text);
});
