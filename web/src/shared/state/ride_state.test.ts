import { expect, test } from "vitest";
import type { RideScene, VehicleScene } from "../scene/scene";
import { aRide, aVehicle } from "../scene/scene_builders";
import { factsOfScene, rideState } from "./ride_state";

const now_ms = 10_000_000;
const minute_ms = 60_000;
const now = { now_ms, known_ms: now_ms };
const old = { now_ms, known_ms: now_ms - minute_ms };

const waiting: Partial<RideScene> = {
  pickup_from_ms: now_ms + 2 * minute_ms,
  pickup_to_ms: now_ms + 8 * minute_ms,
  pickup_eta_ms: now_ms + 4 * minute_ms,
  pickup_earliest_ms: now_ms + 3 * minute_ms,
  pickup_latest_ms: now_ms + 6 * minute_ms,
  arrival_eta_ms: now_ms + 12 * minute_ms,
  arrival_earliest_ms: now_ms + 9 * minute_ms,
  arrival_latest_ms: now_ms + 13 * minute_ms,
};

function stateOf(ride: Partial<RideScene>, vehicle: VehicleScene | null, knowledge = now) {
  return rideState(factsOfScene(aRide({ ...waiting, ...ride })), vehicle, knowledge);
}

test("a waiting party expects its shuttle within a range", () => {
  expect(stateOf({}, aVehicle())).toEqual({
    kind: "expected",
    earliest_ms: now_ms + 3 * minute_ms,
    latest_ms: now_ms + 6 * minute_ms,
  });
});

test("without a range the planned time stands for both ends", () => {
  const without = { pickup_earliest_ms: 0, pickup_latest_ms: 0 };
  expect(stateOf(without, null)).toMatchObject({
    earliest_ms: now_ms + 4 * minute_ms,
    latest_ms: now_ms + 4 * minute_ms,
  });
});

test("late is a pickup planned after the window, or missing when the window is over", () => {
  expect(stateOf({ pickup_eta_ms: now_ms + 9 * minute_ms }, aVehicle()).kind).toBe("late");
  expect(stateOf({ pickup_to_ms: now_ms - 1 }, aVehicle()).kind).toBe("late");
  expect(stateOf({ pickup_to_ms: 0 }, aVehicle()).kind).toBe("expected");
});

test("at the stop is a shuttle with open doors there, or one that has reported the boarding", () => {
  const at_gate = aVehicle({ doors_open: true, next_stop: "gate", speed_mps: 0 });
  expect(stateOf({}, at_gate)).toEqual({ kind: "at_stop" });
  expect(stateOf({ state: "boarding" }, null)).toEqual({ kind: "at_stop" });
});

test("aboard knows whether the next stop is the own one", () => {
  const aboard = { state: "aboard" } as const;
  expect(stateOf(aboard, aVehicle({ next_stop: "elsewhere" }))).toEqual({
    kind: "aboard",
    earliest_ms: now_ms + 9 * minute_ms,
    latest_ms: now_ms + 13 * minute_ms,
    is_next: false,
  });
  expect(stateOf(aboard, aVehicle({ next_stop: "library" }))).toMatchObject({ is_next: true });
  const there = aVehicle({ next_stop: "library", doors_open: true, speed_mps: 0 });
  expect(stateOf(aboard, there)).toEqual({ kind: "at_destination" });
});

test("a stopped shuttle makes no time, before the pickup and aboard", () => {
  const held = aVehicle({ held: true, unavailable_since_ms: 5 });
  const stopped = { kind: "stopped", cause: "held", since_ms: 5, next: "operators_release" };
  expect(stateOf({}, held)).toEqual(stopped);
  expect(stateOf({ state: "aboard" }, held)).toEqual(stopped);
});

test("a shuttle that is held at the stop is still at the stop", () => {
  expect(stateOf({ state: "boarding" }, aVehicle({ held: true }))).toEqual({ kind: "at_stop" });
});

test("without news nothing is known but what was last", () => {
  expect(stateOf({}, aVehicle(), old)).toEqual({
    kind: "unknown",
    since_ms: old.known_ms,
    last: {
      kind: "expected",
      earliest_ms: now_ms + 3 * minute_ms,
      latest_ms: now_ms + 6 * minute_ms,
    },
  });
});

test("a shuttle out of reach leaves its ride unknown since then", () => {
  const silent = aVehicle({ connected: false, heard_ms: now_ms - 30_000 });
  expect(stateOf({ state: "aboard" }, silent)).toMatchObject({
    kind: "unknown",
    since_ms: now_ms - 30_000,
    last: { kind: "aboard" },
  });
});

test("what has ended stays so, also without news", () => {
  for (const end of ["completed", "refused", "cancelled", "no_show", "failed"] as const)
    expect(stateOf({ state: end }, null, old)).toEqual({ kind: "ended", end });
});

test("a ride far ahead is booked, also without news; one that lost its shuttle searches", () => {
  const tomorrow = { pickup_from_ms: now_ms + 1440 * minute_ms, pickup_eta_ms: 0 };
  expect(stateOf(tomorrow, null, old)).toEqual({
    kind: "booked",
    at_ms: now_ms + 1440 * minute_ms,
  });
  expect(stateOf({ state: "requested" }, null)).toEqual({ kind: "searching" });
});
