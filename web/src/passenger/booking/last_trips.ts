import { signal } from "@preact/signals";

/** What the passenger booked before and may want again. */
export interface LastTrip {
  readonly from: string;
  readonly to: string;
  readonly party: number;
  readonly wheelchairs: number;
}

const KEY = "campusloop.trips";
const KEPT = 3;

export const lastTrips = signal<readonly LastTrip[]>(read());

/** Puts the trip first; a trip between the same stops is replaced. */
export function rememberTrip(trip: LastTrip): void {
  lastTrips.value = withTrip(lastTrips.value, trip);
  localStorage.setItem(KEY, JSON.stringify(lastTrips.value));
}

export function withTrip(trips: readonly LastTrip[], trip: LastTrip): readonly LastTrip[] {
  const others = trips.filter((each) => each.from !== trip.from || each.to !== trip.to);
  return [trip, ...others].slice(0, KEPT);
}

function read(): readonly LastTrip[] {
  try {
    const stored: unknown = JSON.parse(localStorage.getItem(KEY) ?? "[]");
    return Array.isArray(stored) ? stored.filter(isTrip) : [];
  } catch (error) {
    // Another version of this page, or a user, wrote something else there.
    if (error instanceof SyntaxError) return [];
    throw error;
  }
}

function isTrip(value: unknown): value is LastTrip {
  if (typeof value !== "object" || value === null) return false;
  const { from, to, party, wheelchairs } = value as Record<string, unknown>;
  return (
    typeof from === "string" &&
    typeof to === "string" &&
    Number.isInteger(party) &&
    Number.isInteger(wheelchairs)
  );
}
