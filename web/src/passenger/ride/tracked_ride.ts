import { signal } from "@preact/signals";
import type { RideTracker } from "./ride_tracker";

/** The ride in the address, or null; the app sets it when the address changes. */
export const trackedRide = signal<RideTracker | null>(null);
