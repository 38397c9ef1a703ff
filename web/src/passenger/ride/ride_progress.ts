import type { Schemas } from "../../shared/api/client";
import type { EndState, RideScene, VehicleScene } from "../../shared/scene/scene";
import { hasDoorsOpenAt } from "../../shared/scene/scene";
import type { Knowledge } from "../../shared/state/knowledge";
import type { RideFacts, RideState } from "../../shared/state/ride_state";
import { factsOfScene, presentRideState, rideState } from "../../shared/state/ride_state";

/** How far a ride has come, from the passenger's point of view; old news does not change it. */
export type RidePhase =
  "booked" | "searching" | "approaching" | "at_pickup" | "aboard" | "at_destination" | EndState;

export interface RideProgress {
  readonly state: RideState;
  readonly phase: RidePhase;
  readonly ended: boolean;
  readonly can_tap_aboard: boolean;
  readonly can_tap_off: boolean;
  readonly can_cancel: boolean;
  /** The passenger is aboard and can leave the shuttle before the destination. */
  readonly can_get_off: boolean;
  readonly can_change_destination: boolean;
}

type Ride = Schemas["RideView"];

/** `live` and `vehicle` are newer than the ticket: where they are known, they win. */
export function rideProgress(
  ticket: Ride,
  live: RideScene | null,
  vehicle: VehicleScene | null,
  knowledge: Knowledge,
): RideProgress {
  const facts = factsOf(ticket, live);
  const phase = phaseOf(facts, vehicle, knowledge.now_ms);
  const waiting = phase === "booked" || phase === "approaching" || phase === "at_pickup";
  const state = rideState(facts, vehicle, knowledge);
  return {
    state,
    phase,
    ended: state.kind === "ended",
    can_tap_aboard: waiting && vehicle !== null && hasDoorsOpenAt(vehicle, ticket.from_stop),
    can_tap_off: phase === "at_destination",
    can_cancel: waiting || phase === "searching",
    can_get_off: phase === "aboard" && !ticket.let_out,
    can_change_destination: waiting || phase === "aboard" || phase === "at_destination",
  };
}

function phaseOf(facts: RideFacts, vehicle: VehicleScene | null, now_ms: number): RidePhase {
  const present = presentRideState(facts, vehicle, now_ms);
  switch (present.kind) {
    case "ended":
      return present.end;
    case "expected":
    case "late":
      return "approaching";
    case "at_stop":
      return "at_pickup";
    default:
      return present.kind;
  }
}

/** The live view's times, and where it has none those of the ticket. */
export function factsOf(ticket: Ride, live: RideScene | null): RideFacts {
  const scene = live === null ? null : factsOfScene(live);
  const { promise } = ticket;
  return {
    state: scene?.state ?? ticket.state,
    from_stop: ticket.from_stop,
    to_stop: ticket.to_stop,
    opens_ms: time(promise?.pickup_from),
    closes_ms: time(promise?.pickup_to),
    pickup_eta_ms: scene?.pickup_eta_ms ?? time(ticket.pickup_eta),
    // A range that the server takes back is gone: the ticket's is older.
    earliest_ms: scene === null ? time(ticket.pickup_earliest) : scene.earliest_ms,
    latest_ms: scene === null ? time(ticket.pickup_latest) : scene.latest_ms,
    arrival_eta_ms: scene?.arrival_eta_ms ?? time(ticket.arrival_eta),
    arrival_earliest_ms: scene === null ? time(ticket.arrival_earliest) : scene.arrival_earliest_ms,
    arrival_latest_ms: scene === null ? time(ticket.arrival_latest) : scene.arrival_latest_ms,
  };
}

/** When a party that waits will arrive; null while no time can be told, and once it is on board. */
export function arrivalOfWaiting(
  facts: RideFacts,
): { readonly earliest_ms: number; readonly latest_ms: number } | null {
  const { state, arrival_earliest_ms: earliest_ms, arrival_latest_ms: latest_ms } = facts;
  if (state !== "assigned" || earliest_ms === null || latest_ms === null) return null;
  return { earliest_ms, latest_ms };
}

function time(timestamp: string | null | undefined): number | null {
  return timestamp == null ? null : Date.parse(timestamp);
}

/** Whole minutes from now until then, rounded down: a passenger who relies on it must not come late. */
export function minutesUntil(then_ms: number, now_ms: number): number {
  return Math.max(0, Math.floor((then_ms - now_ms) / 60_000));
}

/** The same for the later end of a range, rounded up. */
export function minutesUntilAtMost(then_ms: number, now_ms: number): number {
  return Math.max(0, Math.ceil((then_ms - now_ms) / 60_000));
}
