import { expect, test } from "vitest";
import { areaObservations } from "./observation_areas";
import type { VehicleScene } from "./scene";
import { aDrivingView, aScene, aVehicle } from "./scene_builders";

function aSceneWith(count: number, heard_ms: number, vehicles: VehicleScene[] = []) {
  return aScene({ at_ms: 10_000, vehicles, areas: [{ area_id: "a", count, heard_ms }] });
}

test.each([
  [0, 9_500, "clear"],
  [3, 9_500, "occupied"],
  [0, 7_000, "unknown"],
  [3, 7_000, "unknown"],
] as const)("a report of %i people at %i ms makes it %s at 10 s", (count, heard_ms, state) => {
  expect(areaObservations(aSceneWith(count, heard_ms), 10_000)).toEqual([
    {
      area_id: "a",
      state,
      camera_count: count,
      camera_age_ms: 10_000 - heard_ms,
      seen_by_vehicle: false,
    },
  ]);
});

test("an area without a camera has no report, and is seen when a shuttle sees a person there", () => {
  const no_report = { camera_count: -1, camera_age_s: 0 };
  const scene = aScene({
    vehicles: [
      aVehicle({
        driving: aDrivingView({ areas: [{ area_id: "b", track_count: 0, ...no_report }] }),
      }),
      aVehicle({
        driving: aDrivingView({ areas: [{ area_id: "b", track_count: 2, ...no_report }] }),
      }),
    ],
  });
  expect(areaObservations(scene, 0)).toEqual([
    {
      area_id: "b",
      state: "unknown",
      camera_count: null,
      camera_age_ms: null,
      seen_by_vehicle: true,
    },
  ]);
});
