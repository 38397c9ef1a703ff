import type { Schemas } from "../../shared/api/client";
import type { EndState, RideScene, VehicleScene } from "../../shared/scene/scene";
import { hasDoorsOpenAt, hasEnded } from "../../shared/scene/scene";

/** How far a ride has come, from the passenger's point of view. */
export type RidePhase =
  "booked" | "searching" | "approaching" | "at_pickup" | "aboard" | "at_destination" | EndState;

export interface RideProgress {
  readonly phase: RidePhase;
  readonly ended: boolean;
  /** When the shuttle picks the passenger up, or after that when it arrives; null when unknown. */
  readonly eta_ms: number | null;
  readonly can_tap_aboard: boolean;
  readonly can_tap_off: boolean;
  readonly can_cancel: boolean;
  /** The passenger is aboard and can leave the shuttle before the destination. */
  readonly can_get_off: boolean;
  readonly can_change_destination: boolean;
}

type Ride = Omit<Schemas["RideView"], "pickup_eta" | "arrival_eta" | "state"> & {
  readonly state: string;
  readonly pickup_eta: string | null;
  readonly arrival_eta: string | null;
};

/** A pickup so far ahead is a booking: no shuttle is on its way to it yet, and none is being looked for. */
const BOOKED_AHEAD_MS = 30 * 60_000;

export function isFarAhead(ticket: Ride, live: RideScene | null, now_ms: number): boolean {
  const state = live?.state ?? ticket.state;
  if ((state !== "assigned" && state !== "requested") || ticket.promise === null) return false;
  const begins_ms = Date.parse(ticket.promise.pickup_from);
  return Math.min(begins_ms, pickupEta(ticket, live) ?? begins_ms) - now_ms > BOOKED_AHEAD_MS;
}

/** `live` and `vehicle` are newer than the ticket: where they are known, they win. */
export function rideProgress(
  ticket: Ride,
  live: RideScene | null,
  vehicle: VehicleScene | null,
  now_ms: number,
): RideProgress {
  const state = live?.state ?? ticket.state;
  const phase = isFarAhead(ticket, live, now_ms) ? "booked" : ridePhase(state, ticket, vehicle);
  const waiting = phase === "booked" || phase === "approaching" || phase === "at_pickup";
  return {
    phase,
    ended: hasEnded(state),
    eta_ms:
      phase === "approaching" || phase === "booked"
        ? pickupEta(ticket, live)
        : arrivalEta(phase, ticket, live),
    can_tap_aboard: waiting && vehicle !== null && hasDoorsOpenAt(vehicle, ticket.from_stop),
    can_tap_off: phase === "at_destination",
    can_cancel: waiting || phase === "searching",
    can_get_off: phase === "aboard" && !ticket.let_out,
    can_change_destination: waiting || phase === "aboard" || phase === "at_destination",
  };
}

function ridePhase(state: string, ride: Ride, vehicle: VehicleScene | null): RidePhase {
  if (hasEnded(state)) return state;
  const isAt = (stop_id: string) => vehicle !== null && hasDoorsOpenAt(vehicle, stop_id);
  switch (state) {
    case "aboard":
      return isAt(ride.to_stop) ? "at_destination" : "aboard";
    case "boarding":
      return "at_pickup";
    case "assigned":
      return isAt(ride.from_stop) ? "at_pickup" : "approaching";
    default:
      return "searching";
  }
}

function pickupEta(ticket: Ride, live: RideScene | null): number | null {
  return sceneTime(live?.pickup_eta_ms) ?? ticketTime(ticket.pickup_eta);
}

function arrivalEta(phase: RidePhase, ticket: Ride, live: RideScene | null): number | null {
  if (phase !== "aboard" && phase !== "at_pickup") return null;
  return sceneTime(live?.arrival_eta_ms) ?? ticketTime(ticket.arrival_eta);
}

/** A scene writes 0 for an unknown time. */
function sceneTime(time_ms: number | undefined): number | null {
  return time_ms === undefined || time_ms === 0 ? null : time_ms;
}

function ticketTime(time: string | null): number | null {
  return time === null ? null : Date.parse(time);
}

/** Whole minutes from now until then, rounded down: a passenger who relies on it must not come late. */
export function minutesUntil(then_ms: number, now_ms: number): number {
  return Math.max(0, Math.floor((then_ms - now_ms) / 60_000));
}
