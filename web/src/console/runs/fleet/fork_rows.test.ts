import { expect, test } from "vitest";
import { changedRides, figuresOfThen, type ForkedRide, percentile } from "./fork_rows";

function aRide(ride_id: string, changes: Partial<ForkedRide> = {}): ForkedRide {
  return {
    ride_id,
    ride_code: ride_id,
    from_stop: "a",
    to_stop: "b",
    party: 1,
    requested_at: "2026-09-01T08:00:00Z",
    then_state: "completed",
    then_wait_s: 100,
    present_end: "served",
    present_wait_s: 100,
    changed_end: "served",
    changed_wait_s: 100,
    ...changes,
  };
}

test("rides that the change treats alike are left out, the largest difference comes first", () => {
  const rides = [
    aRide("same"),
    aRide("less", { changed_wait_s: 40 }),
    aRide("more", { changed_wait_s: 300 }),
    aRide("won", { present_end: "refused", present_wait_s: null }),
  ];
  expect(changedRides(rides).map((ride) => ride.ride_id)).toEqual(["won", "more", "less"]);
});

test("what was then counts the rides that were picked up", () => {
  const rides = [60, 120, null].map((then_wait_s, k) => aRide(`${k}`, { then_wait_s }));
  expect(figuresOfThen(rides)).toEqual({ served: 2, wait_median_s: 90, wait_p95_s: 117 });
  expect(figuresOfThen([])).toEqual({ served: 0, wait_median_s: null, wait_p95_s: null });
});

test("a percentile lies between its neighbours", () => {
  expect(percentile([1, 2, 3, 4], 0.5)).toBe(2.5);
  expect(percentile([7], 0.95)).toBe(7);
});
