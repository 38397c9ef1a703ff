import { expect, test } from "vitest";
import { nextScene } from "./reducer";
import type { SceneMessage } from "./scene";
import { aRide, aScene, aVehicle } from "./scene_builders";

function aDelta(changes: Partial<Extract<SceneMessage, { type: "delta" }>>): SceneMessage {
  return {
    type: "delta",
    at_ms: 5,
    vehicles: [],
    vehicles_gone: [],
    rides: [],
    rides_gone: [],
    incidents: null,
    areas: [],
    ...changes,
  };
}

const two = aScene({
  vehicles: [aVehicle({ vehicle_id: "a" }), aVehicle({ vehicle_id: "b" })],
  rides: [aRide()],
});

test("a snapshot replaces everything", () => {
  expect(nextScene(two, { type: "snapshot", scene: aScene({ at_ms: 9 }) })).toEqual(
    aScene({ at_ms: 9 }),
  );
});

test("a delta without a scene before it changes nothing", () => {
  expect(nextScene(null, aDelta({}))).toBeNull();
});

test("changed items keep their order, new ones come last, removed ones disappear", () => {
  const scene = nextScene(
    two,
    aDelta({
      vehicles: [aVehicle({ vehicle_id: "c" }), aVehicle({ vehicle_id: "a", speed_mps: 7 })],
      vehicles_gone: ["b"],
    }),
  )!;
  expect(scene.vehicles.map((vehicle) => [vehicle.vehicle_id, vehicle.status?.speed_mps])).toEqual([
    ["a", 7],
    ["c", 3],
  ]);
  expect(scene.at_ms).toBe(5);
});

test("unchanged lists stay the same objects, so that they are not drawn again", () => {
  const scene = nextScene(two, aDelta({}))!;
  expect(scene.vehicles).toBe(two.vehicles);
  expect(scene.rides).toBe(two.rides);
  expect(scene.incidents).toBe(two.incidents);
});
