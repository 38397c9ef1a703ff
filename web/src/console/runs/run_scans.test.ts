import { expect, test, vi } from "vitest";
import { RunScans, type ScanMoment, scanShares } from "./run_scans";

const aScan = (at_ms: number): ScanMoment => ({
  at_ms,
  pose_map: [0, 0, 0],
  agreement: 0.8,
  agrees: [1, 1, 2, 2, 3, 3],
  new: [4, 4],
  through: [],
});

test("nothing is loaded before scans are asked for", async () => {
  const fetch = vi.fn(async () => ({ ok: true as const, value: [aScan(900)] }));
  const scans = new RunScans(fetch);
  scans.want(1200, true);
  expect(fetch).not.toHaveBeenCalled();
  scans.shown.value = true;
  scans.want(1200, true);
  await vi.waitFor(() => expect(scans.at(1200)?.at_ms).toBe(900));
  expect(fetch).toHaveBeenCalledOnce();
});

test("the newest scan before a moment is shown, and none that is old", async () => {
  const scans = new RunScans(async () => ({ ok: true, value: [aScan(3100), aScan(4100)] }));
  scans.shown.value = true;
  expect(scans.at(4500)).toBeUndefined();
  scans.want(4500, true);
  await vi.waitFor(() => expect(scans.arrived.value).toBe(1));
  expect(scans.at(4500)?.at_ms).toBe(4100);
  expect(scans.at(4050)?.at_ms).toBe(3100);
  scans.want(5900, true);
  await vi.waitFor(() => expect(scans.arrived.value).toBe(2));
  expect(scans.at(5900)).toBeNull();
});

test("shares count points", () => {
  expect(scanShares(aScan(0))).toEqual({ agrees: 75, new: 25, through: 0 });
});
