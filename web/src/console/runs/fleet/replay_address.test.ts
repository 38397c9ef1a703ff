import { expect, test } from "vitest";
import { FLEET, fleetReplayOf, idsOfFleetReplay } from "./replay_address";

test("a link leads to the same second and the same shuttle", () => {
  const replay = { start_ms: 1000, end_ms: 61_000, at_ms: 31_234, vehicle_id: "shuttle-1" };
  expect(fleetReplayOf(idsOfFleetReplay(replay))).toEqual(replay);
  const whole = { ...replay, vehicle_id: "" };
  expect(fleetReplayOf(idsOfFleetReplay(whole))).toEqual(whole);
});

test.each([
  [[]],
  [[FLEET]],
  [[FLEET, "abc", "60"]],
  [[FLEET, "1000", "0"]],
  [[FLEET, "1000", "999999999"]],
  [["shuttle-1", "boot-1"]],
])("%j is no fleet replay", (ids) => {
  expect(fleetReplayOf(ids)).toBeNull();
});

test("a moment outside of the replay is its beginning", () => {
  expect(fleetReplayOf([FLEET, "1000", "60", "5"])!.at_ms).toBe(1000);
  expect(fleetReplayOf([FLEET, "1000", "60", "x"])!.at_ms).toBe(1000);
});
