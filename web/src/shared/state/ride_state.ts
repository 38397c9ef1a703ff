import type { EndState, RideScene, VehicleScene } from "../scene/scene";
import { hasDoorsOpenAt, hasEnded } from "../scene/scene";
import type { Knowledge } from "./knowledge";
import { isOld } from "./knowledge";
import type { Stopped, Unknown } from "./vehicle_state";
import { vehicleState } from "./vehicle_state";

/** A ride as it is known, from its ticket and the live view. Times by the server's clock; null for unknown. */
export interface RideFacts {
  readonly state: string;
  readonly from_stop: string;
  readonly to_stop: string;
  readonly opens_ms: number | null;
  readonly closes_ms: number | null;
  readonly pickup_eta_ms: number | null;
  readonly earliest_ms: number | null;
  readonly latest_ms: number | null;
  readonly arrival_eta_ms: number | null;
  readonly arrival_earliest_ms: number | null;
  readonly arrival_latest_ms: number | null;
}

/** Between these the shuttle picks the party up; null while no time can be promised. */
interface Expected {
  readonly kind: "expected" | "late";
  readonly earliest_ms: number | null;
  readonly latest_ms: number | null;
}

/** What is known of a ride, if it is known now. */
export type PresentRideState =
  | { readonly kind: "booked"; readonly at_ms: number | null }
  | { readonly kind: "searching" }
  | Expected
  | { readonly kind: "at_stop" }
  | {
      readonly kind: "aboard";
      /** The party arrives between these; null while it is not known. */
      readonly earliest_ms: number | null;
      readonly latest_ms: number | null;
      /** The next stop is where the party gets off. */
      readonly is_next: boolean;
    }
  | { readonly kind: "at_destination" }
  | Stopped
  | { readonly kind: "ended"; readonly end: EndState };

/** The one state of a ride for phone, console, replay and announcements. */
export type RideState = PresentRideState | (Unknown & { readonly last: PresentRideState });

/** A pickup so far ahead is a booking: no shuttle is on its way to it yet, and none is being looked for. */
export const BOOKED_AHEAD_MS = 30 * 60_000;

/**
 * Nothing is made up: old news is "unknown" with what was known last, and a shuttle that stands or is out of
 * reach makes no time.
 */
export function rideState(
  ride: RideFacts,
  vehicle: VehicleScene | null,
  knowledge: Knowledge,
): RideState {
  const present = presentRideState(ride, vehicle, knowledge.now_ms);
  if (present.kind === "ended" || present.kind === "booked") return present;
  if (isOld(knowledge)) return { kind: "unknown", since_ms: knowledge.known_ms, last: present };
  if (vehicle === null || present.kind === "searching") return present;
  const shuttle = vehicleState(vehicle, knowledge);
  if (shuttle.kind === "unknown") return { ...shuttle, last: present };
  return shuttle.kind === "stopped" && isUnderWay(present) ? shuttle : present;
}

function isUnderWay({ kind }: PresentRideState): boolean {
  return kind === "expected" || kind === "late" || kind === "aboard";
}

/** What the newest news says, however old it is. A shuttle that stands is not looked at. */
export function presentRideState(
  ride: RideFacts,
  vehicle: VehicleScene | null,
  now_ms: number,
): Exclude<PresentRideState, Stopped> {
  if (hasEnded(ride.state)) return { kind: "ended", end: ride.state };
  if (isFarAhead(ride, now_ms))
    return { kind: "booked", at_ms: ride.pickup_eta_ms ?? ride.opens_ms };
  const isAt = (stop_id: string) => vehicle !== null && hasDoorsOpenAt(vehicle, stop_id);
  switch (ride.state) {
    case "aboard":
      if (isAt(ride.to_stop)) return { kind: "at_destination" };
      return {
        kind: "aboard",
        earliest_ms: ride.arrival_earliest_ms ?? ride.arrival_eta_ms,
        latest_ms: ride.arrival_latest_ms ?? ride.arrival_eta_ms,
        is_next: vehicle?.task.next_stop === ride.to_stop,
      };
    case "boarding":
      return { kind: "at_stop" };
    case "assigned":
      return isAt(ride.from_stop) ? { kind: "at_stop" } : expected(ride, now_ms);
    default:
      return { kind: "searching" };
  }
}

/** Late is a pickup that is planned after the promised window, or has not come when it is over. */
function expected(ride: RideFacts, now_ms: number): Expected {
  const { closes_ms, pickup_eta_ms } = ride;
  const is_late = closes_ms !== null && Math.max(pickup_eta_ms ?? 0, now_ms) > closes_ms;
  return {
    kind: is_late ? "late" : "expected",
    earliest_ms: ride.earliest_ms ?? pickup_eta_ms,
    latest_ms: ride.latest_ms ?? pickup_eta_ms,
  };
}

function isFarAhead({ state, opens_ms, pickup_eta_ms }: RideFacts, now_ms: number): boolean {
  if ((state !== "assigned" && state !== "requested") || opens_ms === null) return false;
  return Math.min(opens_ms, pickup_eta_ms ?? opens_ms) - now_ms > BOOKED_AHEAD_MS;
}

/** A ride of the live view alone, as the console and a replay have it. */
export function factsOfScene(ride: RideScene): RideFacts {
  return {
    state: ride.state,
    from_stop: ride.from_stop,
    to_stop: ride.to_stop,
    opens_ms: sceneTime(ride.pickup_from_ms),
    closes_ms: sceneTime(ride.pickup_to_ms),
    pickup_eta_ms: sceneTime(ride.pickup_eta_ms),
    earliest_ms: sceneTime(ride.pickup_earliest_ms),
    latest_ms: sceneTime(ride.pickup_latest_ms),
    arrival_eta_ms: sceneTime(ride.arrival_eta_ms),
    arrival_earliest_ms: sceneTime(ride.arrival_earliest_ms),
    arrival_latest_ms: sceneTime(ride.arrival_latest_ms),
  };
}

/** A scene writes 0 for an unknown time. */
function sceneTime(time_ms: number): number | null {
  return time_ms === 0 ? null : time_ms;
}
