import { expect, test } from "vitest";
import type { Schemas } from "../../shared/api/client";
import { aRide, aVehicle } from "../../shared/scene/scene_builders";
import { factsOf, minutesUntil, minutesUntilAtMost, rideProgress } from "./ride_progress";

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
  vehicle_name: "Shuttle 1",
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
const now_ms = Date.parse("2026-09-01T08:05:00Z");
const now = { now_ms, known_ms: now_ms };
const at_gate = aVehicle({ doors_open: true, next_stop: "gate", speed_mps: 0 });
const at_library = aVehicle({ doors_open: true, next_stop: "library", speed_mps: 0 });

test("while the shuttle approaches, the passenger can only cancel", () => {
  const progress = rideProgress(ticket, null, aVehicle({ next_stop: "gate" }), now);
  expect(progress).toMatchObject({
    phase: "approaching",
    can_tap_aboard: false,
    can_tap_off: false,
    can_cancel: true,
    state: { kind: "expected", earliest_ms: Date.parse("2026-09-01T08:10:00Z") },
  });
});

test("boarding opens when the shuttle stands at the pickup stop with open doors", () => {
  expect(rideProgress(ticket, null, at_gate, now)).toMatchObject({
    phase: "at_pickup",
    can_tap_aboard: true,
  });
  const closed = aVehicle({ next_stop: "gate", speed_mps: 0 });
  expect(rideProgress(ticket, null, closed, now).can_tap_aboard).toBe(false);
  expect(rideProgress(ticket, null, at_library, now).can_tap_aboard).toBe(false);
});

test("getting off opens when the shuttle stands at the destination", () => {
  const aboard = aRide({ state: "aboard" });
  expect(rideProgress(ticket, aboard, aVehicle(), now)).toMatchObject({
    phase: "aboard",
    can_tap_off: false,
    can_cancel: false,
  });
  expect(rideProgress(ticket, aboard, at_library, now)).toMatchObject({
    phase: "at_destination",
    can_tap_off: true,
  });
});

test("the live view is newer than the ticket, and its 0 means unknown", () => {
  const live = aRide({ state: "assigned", pickup_eta_ms: 5 });
  expect(factsOf(ticket, live).pickup_eta_ms).toBe(5);
  expect(factsOf(ticket, aRide()).pickup_eta_ms).toBe(Date.parse("2026-09-01T08:10:00Z"));
  const told = { ...ticket, pickup_earliest: "2026-09-01T08:09:00Z" };
  expect(factsOf(told, null).earliest_ms).toBe(Date.parse("2026-09-01T08:09:00Z"));
  // The server no longer promises a time: the ticket's is old.
  expect(factsOf(told, aRide()).earliest_ms).toBeNull();
});

test("old news changes no phase and allows the same, but is called unknown", () => {
  const lost = { now_ms, known_ms: now_ms - 60_000 };
  expect(rideProgress(ticket, aRide(), aVehicle(), lost)).toMatchObject({
    phase: "approaching",
    can_cancel: true,
    state: { kind: "unknown", since_ms: now_ms - 60_000, last: { kind: "expected" } },
  });
});

test("a ride that lost its shuttle waits for another one and can be cancelled", () => {
  const live = aRide({ state: "requested" });
  expect(rideProgress(ticket, live, null, now)).toMatchObject({
    phase: "searching",
    can_cancel: true,
  });
});

test.each(["completed", "refused", "cancelled", "no_show", "failed"] as const)(
  "%s ends the ride",
  (state) => {
    expect(rideProgress({ ...ticket, state }, null, at_gate, now)).toMatchObject({
      phase: state,
      ended: true,
      can_tap_aboard: false,
      can_cancel: false,
    });
  },
);

test("a ride for tomorrow is booked, whatever shuttle it is given to", () => {
  const promise = {
    pickup_from: "2026-09-02T08:00:00Z",
    pickup_to: "2026-09-02T08:05:00Z",
    arrive_by: "2026-09-02T08:20:00Z",
  };
  const tomorrow = { ...ticket, promise, pickup_eta: "2026-09-02T08:01:00Z" };
  expect(rideProgress(tomorrow, null, aVehicle(), now)).toMatchObject({
    phase: "booked",
    can_cancel: true,
    can_tap_aboard: false,
  });
  const unassigned = { ...tomorrow, state: "requested" as const, pickup_eta: null };
  expect(rideProgress(unassigned, null, null, now).phase).toBe("booked");
  const soon_ms = Date.parse("2026-09-02T07:45:00Z");
  const soon = { now_ms: soon_ms, known_ms: soon_ms };
  expect(rideProgress(tomorrow, null, aVehicle(), soon).phase).toBe("approaching");
});

test("minutes are rounded down and never negative", () => {
  expect(minutesUntil(119_000, 0)).toBe(1);
  expect(minutesUntil(59_000, 0)).toBe(0);
  expect(minutesUntil(0, 60_000)).toBe(0);
  expect(minutesUntilAtMost(119_000, 0)).toBe(2);
  expect(minutesUntilAtMost(120_000, 0)).toBe(2);
});
