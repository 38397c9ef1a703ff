import type { Schemas } from "../../shared/api/client";
import type { RideScene, VehicleScene } from "../../shared/scene/scene";
import { standsAt } from "../../shared/scene/scene";

/** Where a ride stands, as its passenger would tell it. */
export type Chapter =
  | "looking"
  | "coming"
  | "here"
  | "riding"
  | "arrived"
  | "done"
  | "refused"
  | "cancelled"
  | "missed"
  | "failed";

export interface Story {
  readonly chapter: Chapter;
  readonly ended: boolean;
  /** The moment that the passenger waits for: pickup, then arrival; null when nobody knows. */
  readonly eta_ms: number | null;
  readonly can_tap_aboard: boolean;
  readonly can_tap_off: boolean;
  readonly can_cancel: boolean;
  /** Aboard: to be let out before the destination. */
  readonly can_get_off: boolean;
  readonly can_redirect: boolean;
}

type Ride = Omit<Schemas["RideView"], "pickup_eta" | "arrival_eta" | "state"> & {
  readonly state: string;
  readonly pickup_eta: string | null;
  readonly arrival_eta: string | null;
};

const ENDINGS: Readonly<Record<string, Chapter>> = {
  completed: "done",
  refused: "refused",
  cancelled: "cancelled",
  no_show: "missed",
  failed: "failed",
};

/** live and vehicle are newer than the ticket and win where they are known. */
export function storyOf(ticket: Ride, live: RideScene | null, vehicle: VehicleScene | null): Story {
  const state = live?.state ?? ticket.state;
  const chapter = chapterOf(state, ticket, vehicle);
  const waiting = chapter === "coming" || chapter === "here";
  return {
    chapter,
    ended: state in ENDINGS,
    eta_ms: chapter === "coming" ? pickupEta(ticket, live) : arrivalEta(chapter, ticket, live),
    can_tap_aboard: waiting && vehicle !== null && standsAt(vehicle, ticket.from_stop),
    can_tap_off: chapter === "arrived",
    can_cancel: waiting || chapter === "looking",
    can_get_off: chapter === "riding" && !ticket.let_out,
    can_redirect: waiting || chapter === "riding" || chapter === "arrived",
  };
}

function chapterOf(state: string, ride: Ride, vehicle: VehicleScene | null): Chapter {
  const ending = ENDINGS[state];
  if (ending !== undefined) return ending;
  if (state === "aboard")
    return vehicle !== null && standsAt(vehicle, ride.to_stop) ? "arrived" : "riding";
  if (state === "boarding") return "here";
  if (state === "assigned")
    return vehicle !== null && standsAt(vehicle, ride.from_stop) ? "here" : "coming";
  return "looking";
}

function pickupEta(ticket: Ride, live: RideScene | null): number | null {
  return known(live?.pickup_eta_ms) ?? parsed(ticket.pickup_eta);
}

function arrivalEta(chapter: Chapter, ticket: Ride, live: RideScene | null): number | null {
  if (chapter !== "riding" && chapter !== "here") return null;
  return known(live?.arrival_eta_ms) ?? parsed(ticket.arrival_eta);
}

/** The scene writes 0 for a moment that nobody knows. */
function known(moment_ms: number | undefined): number | null {
  return moment_ms === undefined || moment_ms === 0 ? null : moment_ms;
}

function parsed(moment: string | null): number | null {
  return moment === null ? null : Date.parse(moment);
}

/** Whole minutes from now until then, rounded down: whoever trusts it must not come late. */
export function minutesUntil(then_ms: number, now_ms: number): number {
  return Math.max(0, Math.floor((then_ms - now_ms) / 60_000));
}
