import type { Schemas } from "../../../shared/api/client";

export type ForkView = Readonly<Schemas["ForkView"]>;
export type ForkedRide = ForkView["rides"][number];

/** What was then, counted as the forks count it. */
export interface ThenFigures {
  readonly served: number;
  readonly wait_median_s: number | null;
  readonly wait_p95_s: number | null;
}

export function figuresOfThen(rides: readonly ForkedRide[]): ThenFigures {
  const waits_s = rides
    .map((ride) => ride.then_wait_s)
    .filter((wait_s) => wait_s !== null)
    .sort((one, other) => one - other);
  return {
    served: waits_s.length,
    wait_median_s: percentile(waits_s, 0.5),
    wait_p95_s: percentile(waits_s, 0.95),
  };
}

/** Linear between neighbours, as the server computes the forks' own. */
export function percentile(sorted: readonly number[], share: number): number | null {
  if (sorted.length === 0) return null;
  const place = share * (sorted.length - 1);
  const below = Math.floor(place);
  const [low, high] = [sorted[below]!, sorted[Math.min(below + 1, sorted.length - 1)]!];
  return low + (place - below) * (high - low);
}

/** Rides that the change treats differently, those that gain or lose most first. */
export function changedRides(rides: readonly ForkedRide[]): readonly ForkedRide[] {
  const weight = (ride: ForkedRide) =>
    ride.present_end !== ride.changed_end
      ? Number.MAX_SAFE_INTEGER
      : Math.abs((ride.changed_wait_s ?? 0) - (ride.present_wait_s ?? 0));
  return rides
    .filter((ride) => weight(ride) >= 1)
    .sort((one, other) => weight(other) - weight(one));
}
