import { expect, test } from "vitest";
import { aScene, aStatus, aVehicle } from "../../shared/scene/scene_builders";
import { bandColumns, type LocalizationPhase, phaseShares } from "./localization_band";
import { BUCKETS } from "./marks";

function aRun(...told: readonly (readonly [LocalizationPhase, number | null] | null)[]) {
  return told.map((one, k) => {
    const localization =
      one === null ? null : { phase: one[0], position_std_m: one[1], agreement: null };
    const vehicle = { ...aVehicle(), status: aStatus({ localization }) };
    return aScene({ at_ms: 1000 * k, vehicles: [vehicle] });
  });
}

test("every part of the timeline has the phase of its time, without holes", () => {
  const columns = bandColumns(
    aRun(["tracking", 0.1], ["doubtful", 0.6], ["tracking", 0.1]),
    0,
    2000,
  );
  expect(columns.map(({ place }) => place)).toEqual([...Array(BUCKETS).keys()]);
  expect(columns[0]).toEqual({ place: 0, phase: "tracking", height: 0.2 });
  expect(columns[BUCKETS / 2]).toEqual({ place: BUCKETS / 2, phase: "doubtful", height: 0.6 });
});

test("where many statuses share a part, the worst is shown", () => {
  const run = aRun(["tracking", 0.1], ["lost", null], ["recovered", 0.3], ["tracking", 0.1]);
  const [first] = bandColumns(run, 0, 1_000_000);
  expect(first).toEqual({ place: 0, phase: "lost", height: 1 });
});

test("a gap in the run stays empty", () => {
  const [before, after] = aRun(["tracking", 0.1], ["tracking", 0.1]);
  const columns = bandColumns([before!, { ...after!, at_ms: 100_000 }], 0, 100_000);
  expect(columns.length).toBe(9);
});

test("an older agent that does not tell has no band", () => {
  expect(bandColumns(aRun(null, null), 0, 1000)).toEqual([]);
  expect(phaseShares(aRun(null, null))).toEqual([]);
});

test("shares tell how the whole run was, the worst first", () => {
  const run = aRun(["tracking", 0.1], ["tracking", 0.1], ["lost", null], ["tracking", 0.1], null);
  expect(phaseShares(run)).toEqual([
    { phase: "lost", share: 0.25 },
    { phase: "tracking", share: 0.75 },
  ]);
});
