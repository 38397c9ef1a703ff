import { expect, test } from "vitest";
import type { AnnouncementDraft } from "./announcement_draft";
import { bodyOf } from "./announcement_draft";

const draft: AnnouncementDraft = {
  text_zh: " 今天在东侧 ",
  text_en: "East side today",
  audience: "stops",
  chosen: ["A"],
  from: "2026-11-23T08:00",
  until: "",
};

test("times are those of the campus, and spaces around the texts go", () => {
  expect(bodyOf(draft, "Asia/Shanghai")).toEqual({
    text_zh: "今天在东侧",
    text_en: "East side today",
    audience: "stops",
    stop_ids: ["A"],
    vehicle_ids: [],
    starts_at: "2026-11-23T00:00:00.000Z",
    ends_at: null,
  });
});

test.each([
  ["all", [], []],
  ["stops", ["A"], []],
  ["shuttles", [], ["A"]],
] as const)("what is chosen goes to %s alone", (audience, stop_ids, vehicle_ids) => {
  const body = bodyOf({ ...draft, audience }, "UTC");
  expect([body.stop_ids, body.vehicle_ids]).toEqual([stop_ids, vehicle_ids]);
});
