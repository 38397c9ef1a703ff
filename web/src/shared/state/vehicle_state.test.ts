import { expect, test } from "vitest";
import { aVehicle } from "../scene/scene_builders";
import { vehicleState } from "./vehicle_state";

const now_ms = 1_000_000;
const now = { now_ms, known_ms: now_ms };

test("a shuttle that moves drives, one with open doors is at its stop, any other stands", () => {
  expect(vehicleState(aVehicle(), now)).toEqual({ kind: "driving" });
  const at_gate = aVehicle({ doors_open: true, next_stop: "gate", speed_mps: 0 });
  expect(vehicleState(at_gate, now)).toEqual({ kind: "at_stop", stop_id: "gate" });
  expect(vehicleState(aVehicle({ speed_mps: 0 }), now)).toEqual({ kind: "standing" });
});

test("a stopped shuttle says why, since when, and what happens next", () => {
  const held = { held: true, unavailable_since_ms: 900_000 };
  expect(vehicleState(aVehicle(held), now)).toEqual({
    kind: "stopped",
    cause: "held",
    since_ms: 900_000,
    next: "operators_release",
  });
  expect(vehicleState(aVehicle({ ...held, hold_ends_ms: 1_060_000 }), now)).toMatchObject({
    next: "resumes_at",
    resumes_ms: 1_060_000,
  });
  expect(vehicleState(aVehicle({ mode: "fault" }), now)).toMatchObject({
    cause: "fault",
    since_ms: null,
    next: "operators_check",
  });
  expect(vehicleState(aVehicle({ mode: "minimal_risk" }), now)).toMatchObject({ cause: "fault" });
  expect(vehicleState(aVehicle({ mode: "manual" }), now)).toMatchObject({
    cause: "manual",
    next: "person_drives",
  });
});

test("a shuttle out of reach is unknown since it was heard last", () => {
  expect(vehicleState(aVehicle({ connected: false, heard_ms: 950_000 }), now)).toEqual({
    kind: "unknown",
    since_ms: 950_000,
  });
  const never = aVehicle({ connected: false, unavailable_since_ms: 940_000 });
  expect(vehicleState(never, now)).toEqual({ kind: "unknown", since_ms: 940_000 });
});

test("a shuttle that has said nothing for a while is unknown before the server calls it lost", () => {
  expect(vehicleState(aVehicle({ heard_ms: now_ms - 6_999 }), now).kind).toBe("driving");
  expect(vehicleState(aVehicle({ heard_ms: now_ms - 7_001 }), now)).toEqual({
    kind: "unknown",
    since_ms: now_ms - 7_001,
  });
});

test("a page without news knows nothing of any shuttle", () => {
  const old = { now_ms, known_ms: now_ms - 7_001 };
  expect(vehicleState(aVehicle({ held: true }), old)).toEqual({
    kind: "unknown",
    since_ms: now_ms - 7_001,
  });
  const cut_off = { ...now, is_cut_off: true };
  expect(vehicleState(aVehicle(), cut_off)).toEqual({ kind: "unknown", since_ms: now_ms });
});
