import { monotonic_ms } from "../../shared/live/clock";
import type { Condition } from "../../shared/scene/condition";
import { conditionOf } from "../../shared/scene/condition";
import { language } from "../../shared/texts/language";
import { formatTimeOrDateTime } from "../../shared/texts/times";
import { texts } from "../texts/texts";
import type { RidePhase, RideProgress } from "./ride_progress";
import { minutesUntil } from "./ride_progress";
import type { RideTracker, Ticket } from "./ride_tracker";

/** The shuttle's name. Before it is known, "Shuttle": its id is nothing to people. */
export function vehicleName(ride: RideTracker): string {
  return ride.vehicle.value?.facts.name ?? texts.value.shuttle;
}

/** The title without times. A screen reader announces it, so it changes only when the phase does. */
export function titleText(phase: RidePhase, vehicle: string): string {
  const text = texts.value[phase];
  return typeof text === "string" ? text : text(vehicle);
}

/** The title with its time, which changes every minute. */
export function titleWithTime(
  ride: RideTracker,
  { phase, eta_ms }: RideProgress,
  timezone: string,
): string {
  const t = texts.value;
  const name = vehicleName(ride);
  if (phase === "booked") return bookedTitle(ride, eta_ms, timezone);
  if (phase !== "approaching" && phase !== "aboard") return titleText(phase, name);
  const stopped = stoppedTitle(ride, name);
  if (stopped !== null) return stopped;
  if (eta_ms === null) return titleText(phase, name);
  const now_ms = monotonic_ms.value > 0 ? (ride.link.now_ms() ?? Date.now()) : Date.now();
  const minutes = minutesUntil(eta_ms, now_ms);
  // Without news a time may stand there, but nothing counts down.
  if (minutes >= 60 || ride.link.state.value !== "open") {
    const time = formatTimeOrDateTime(eta_ms, now_ms, language.value, timezone);
    return phase === "approaching" ? t.approaching_at(name, time) : t.aboard_at(time);
  }
  const soon = minutes === 0 ? t.under_a_minute : t.in_minutes(minutes);
  return phase === "approaching" ? t.approaching_in(name, soon) : t.aboard_in(soon);
}

function bookedTitle(ride: RideTracker, eta_ms: number | null, timezone: string): string {
  const begins = eta_ms ?? ride.ticket.value?.promise?.pickup_from;
  if (begins === undefined) return texts.value.booked;
  const now_ms = ride.link.now_ms() ?? Date.now();
  return texts.value.booked_for(formatTimeOrDateTime(begins, now_ms, language.value, timezone));
}

export function detailText(
  ticket: Ticket,
  { phase }: RideProgress,
  wheelchairs_max: number,
): string {
  const t = texts.value;
  switch (phase) {
    case "searching":
      return t.searching_detail;
    case "at_pickup":
      return t.at_pickup_detail;
    case "at_destination":
      return t.at_destination_detail;
    case "completed":
      return ticket.left_early ? t.completed_early : t.completed_detail;
    case "refused":
      // A time of day changes nothing where no shuttle has so many places at all.
      if (ticket.reason === "wheelchair" && ticket.wheelchairs > wheelchairs_max)
        return t.wheelchair_places(wheelchairs_max);
      return t.reasons[ticket.reason] ?? ticket.reason_detail;
    case "cancelled":
      return /_(operator|developer)$/.test(ticket.reason) ? t.cancelled_by_operator : "";
    case "no_show":
      return t.no_show_detail;
    case "failed":
      return t.failed_detail;
    default:
      return "";
  }
}

/** Of a shuttle that stands, or is out of reach, for a reason that no expected time knows of; else null. */
function stoppedTitle(ride: RideTracker, name: string): string | null {
  const vehicle = ride.vehicle.value;
  if (vehicle === null) return null;
  const condition = conditionOf(vehicle);
  if (condition === "offline") return texts.value.unreachable(name);
  return STOPPED.has(condition) ? texts.value.stopped(name) : null;
}

const STOPPED: ReadonlySet<Condition> = new Set(["held", "manual", "fault", "minimal_risk"]);

/** Why the shuttle stands, when the passenger cannot know it. */
export function delayText(ride: RideTracker, { phase }: RideProgress): string {
  const vehicle = ride.vehicle.value;
  if (vehicle === null || (phase !== "approaching" && phase !== "aboard")) return "";
  const t = texts.value;
  switch (conditionOf(vehicle)) {
    case "offline":
      return t.vehicle_offline;
    case "held":
      return t.vehicle_held;
    case "manual":
      return t.vehicle_manual;
    case "fault":
    case "minimal_risk":
      return t.vehicle_stopped;
    default:
      return "";
  }
}
