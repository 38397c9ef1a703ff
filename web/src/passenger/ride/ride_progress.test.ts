import { expect, test } from "vitest";
import type { Schemas } from "../../shared/api/client";
import { aRide, aVehicle } from "../../shared/scene/scene_builders";
import { minutesUntil, storyOf } from "./ride_progress";

const ticket: Schemas["RideView"] = {
  ride_id: "ride-1",
  ride_code: "K7MQ2X",
  state: "assigned",
  from_stop: "gate",
  to_stop: "library",
  party: 1,
  wheelchairs: 0,
  earliest: "2026-09-01T08:00:00Z",
  requested_at: "2026-09-01T08:00:00Z",
  promise: null,
  vehicle_id: "shuttle-1",
  pickup_eta: "2026-09-01T08:10:00Z",
  arrival_eta: "2026-09-01T08:20:00Z",
  boarded_at: null,
  ended_at: null,
  reason: "",
  reason_detail: "",
  promise_broken: false,
  left_early: false,
  first_to_stop: null,
  let_out: false,
  stranded_by: null,
};
const at_gate = aVehicle({ doors_open: true, next_stop: "gate", speed_mps: 0 });
const at_library = aVehicle({ doors_open: true, next_stop: "library", speed_mps: 0 });

test("while the shuttle is coming one can only cancel", () => {
  const story = storyOf(ticket, null, aVehicle({ next_stop: "gate" }));
  expect(story).toMatchObject({
    chapter: "coming",
    can_tap_aboard: false,
    can_tap_off: false,
    can_cancel: true,
    eta_ms: Date.parse("2026-09-01T08:10:00Z"),
  });
});

test("boarding opens when the shuttle stands at the pickup stop with open doors", () => {
  expect(storyOf(ticket, null, at_gate)).toMatchObject({ chapter: "here", can_tap_aboard: true });
  const shut = { ...at_gate, doors_open: false };
  expect(storyOf(ticket, null, shut).can_tap_aboard).toBe(false);
  expect(storyOf(ticket, null, at_library).can_tap_aboard).toBe(false);
});

test("getting off opens when the shuttle stands at the destination", () => {
  const aboard = aRide({ state: "aboard" });
  expect(storyOf(ticket, aboard, aVehicle())).toMatchObject({
    chapter: "riding",
    can_tap_off: false,
    can_cancel: false,
  });
  expect(storyOf(ticket, aboard, at_library)).toMatchObject({
    chapter: "arrived",
    can_tap_off: true,
  });
});

test("the live view is newer than the ticket, and its 0 means unknown", () => {
  const live = aRide({ state: "assigned", pickup_eta_ms: 5 });
  expect(storyOf(ticket, live, null).eta_ms).toBe(5);
  expect(storyOf(ticket, aRide(), null).eta_ms).toBe(Date.parse("2026-09-01T08:10:00Z"));
});

test("a ride that lost its shuttle is being looked after and can be cancelled", () => {
  const live = aRide({ state: "requested" });
  expect(storyOf(ticket, live, null)).toMatchObject({ chapter: "looking", can_cancel: true });
});

test.each([
  ["completed", "done"],
  ["refused", "refused"],
  ["cancelled", "cancelled"],
  ["no_show", "missed"],
  ["failed", "failed"],
])("%s ends the story as %s", (state, chapter) => {
  const story = storyOf({ ...ticket, state: state as Schemas["RideState"] }, null, at_gate);
  expect(story).toMatchObject({ chapter, ended: true, can_tap_aboard: false, can_cancel: false });
});

test("minutes are rounded down and never negative", () => {
  expect(minutesUntil(119_000, 0)).toBe(1);
  expect(minutesUntil(59_000, 0)).toBe(0);
  expect(minutesUntil(0, 60_000)).toBe(0);
});
