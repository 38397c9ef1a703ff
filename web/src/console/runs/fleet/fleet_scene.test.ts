import { expect, test } from "vitest";
import { conditionOf } from "../../../shared/scene/condition";
import { type PastRide, sceneOfPast, type Track } from "./fleet_scene";

const FLEET = [{ vehicle_id: "shuttle-1", name: "Shuttle 1", seats: 6 }];

function aTrack(at_ms: number[], x_m: number[], changes: Partial<Track> = {}): Track {
  const all = <T>(value: T) => at_ms.map(() => value);
  return {
    vehicle_id: "shuttle-1",
    at_ms,
    x_m,
    y_m: all(0),
    yaw_rad: all(0),
    speed_mps: all(2),
    mode: all("autonomous" as const),
    battery_ratio: all(0.5),
    ...changes,
  };
}

function shown(moment_ms: number, track: Track, rides: PastRide[] = []) {
  return sceneOfPast(moment_ms, FLEET, [track], rides, "m").vehicles[0]!;
}

test.each([
  [1000, 0],
  [1500, 1],
  [2000, 2],
  [2250, 3],
])("at %i the shuttle is at %d m", (moment_ms, x_m) => {
  expect(shown(moment_ms, aTrack([1000, 2000, 3000], [0, 2, 6])).status!.pose_map[0]).toBe(x_m);
});

test("a shuttle turns the short way round", () => {
  const track = aTrack([0, 1000], [0, 1], { yaw_rad: [3.1, -3.1] });
  expect(Math.abs(shown(500, track).status!.pose_map[2])).toBeCloseTo(Math.PI, 2);
});

test("a shuttle is not drawn on its way through a gap or a leap", () => {
  expect(shown(5000, aTrack([0, 10_000], [0, 20])).status!.pose_map[0]).toBe(0);
  expect(shown(500, aTrack([0, 1000], [0, 500])).status!.pose_map[0]).toBe(0);
});

test("a shuttle that was not heard has no place, and no condition but that", () => {
  for (const moment_ms of [500, 40_000]) {
    const vehicle = shown(moment_ms, aTrack([1000, 2000], [0, 2]));
    expect(vehicle.status).toBeNull();
    expect(conditionOf(vehicle)).toBe("offline");
  }
  expect(conditionOf(sceneOfPast(0, FLEET, [], [], "m").vehicles[0]!)).toBe("offline");
});

test("a shuttle that was taken off the fleet since is shown under its id", () => {
  const track = aTrack([0], [0], { vehicle_id: "old-7" });
  const scene = sceneOfPast(0, FLEET, [track], [], "m");
  expect(scene.vehicles.map((vehicle) => vehicle.facts.name)).toEqual(["Shuttle 1", "old-7"]);
});

test("who is aboard is known from when they got on until the ride ended", () => {
  const ride: PastRide = {
    ride_id: "r",
    ride_code: "ABC234",
    state: "completed",
    vehicle_id: "shuttle-1",
    from_stop: "a",
    to_stop: "b",
    party: 3,
    requested_ms: 0,
    boarded_ms: 1000,
    ended_ms: 2000,
  };
  const track = aTrack([0, 1000, 2000], [0, 1, 2]);
  const aboard = [999, 1000, 1999, 2000].map((at) => shown(at, track, [ride]).task.people_aboard);
  expect(aboard).toEqual([0, 3, 3, 0]);
  expect(shown(2500, track, [{ ...ride, ended_ms: 0 }]).task.people_aboard).toBe(3);
});
