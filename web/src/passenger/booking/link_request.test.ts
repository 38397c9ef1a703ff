import { beforeEach, expect, test } from "vitest";
import { fillFromLink } from "./link_request";
import { destination, pickup } from "./ride_request";

const stop = (stop_id: string) => ({
  stop_id,
  name: "",
  name_en: "",
  lane_id: "",
  s_m: 0,
  x_m: 0,
  y_m: 0,
  placed_by: "tag",
});
const stops = [stop("gate"), stop("library")];

beforeEach(() => {
  pickup.value = destination.value = "";
});

test("a printed code at a stop fills in where one is", () => {
  expect(fillFromLink("?from=gate", stops)).toBe(false);
  expect([pickup.value, destination.value]).toEqual(["gate", ""]);
});

test("both ends, but never the same one twice", () => {
  expect(fillFromLink("?from=gate&to=library", stops)).toBe(false);
  expect([pickup.value, destination.value]).toEqual(["gate", "library"]);
  destination.value = "";
  fillFromLink("?from=gate&to=gate", stops);
  expect(destination.value).toBe("");
});

test("an old code whose stop is gone is told", () => {
  expect(fillFromLink("?from=moved", stops)).toBe(true);
  expect(pickup.value).toBe("");
});
