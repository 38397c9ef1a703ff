import { expect, test } from "vitest";
import type { Announcement, Journey } from "./current_announcements";
import { concerning } from "./current_announcements";

const one = (more: Partial<Announcement>): Announcement => ({
  announcement_id: "a-1",
  text_zh: "今天在东侧",
  text_en: "East side today",
  audience: "all",
  stop_ids: [],
  vehicle_ids: [],
  starts_at: "2026-11-23T08:00:00Z",
  ends_at: null,
  ...more,
});
const nowhere: Journey = { stop_ids: [], vehicle_id: null };
const journey: Journey = { stop_ids: ["A", "B"], vehicle_id: "v" };

test.each<[string, Partial<Announcement>, Journey, boolean]>([
  ["to all, before anything is chosen", {}, nowhere, true],
  ["to every stop, before a stop is chosen", { audience: "stops" }, nowhere, false],
  ["to every stop", { audience: "stops" }, journey, true],
  ["to the destination", { audience: "stops", stop_ids: ["B"] }, journey, true],
  ["to another stop", { audience: "stops", stop_ids: ["C"] }, journey, false],
  ["to every shuttle, before there is one", { audience: "shuttles" }, nowhere, false],
  ["to every shuttle", { audience: "shuttles" }, journey, true],
  ["to the shuttle that comes", { audience: "shuttles", vehicle_ids: ["v"] }, journey, true],
  ["to another shuttle", { audience: "shuttles", vehicle_ids: ["w"] }, journey, false],
])("one %s", (_, more, about, is_shown) => {
  expect(concerning([one(more)], about).length === 1).toBe(is_shown);
});
