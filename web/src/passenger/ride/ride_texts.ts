import { serverNow_ms } from "../../shared/api/server_time";
import { monotonic_ms } from "../../shared/live/clock";
import type { PresentRideState, RideState } from "../../shared/state/ride_state";
import type { Stopped } from "../../shared/state/vehicle_state";
import { language } from "../../shared/texts/language";
import { formatTime, formatTimeOrDateTime } from "../../shared/texts/times";
import { texts } from "../texts/texts";
import type { RidePhase, RideProgress } from "./ride_progress";
import { minutesUntil, minutesUntilAtMost } from "./ride_progress";
import type { RideTracker, Ticket } from "./ride_tracker";

/** From this on a time of day says more than a number of minutes. */
const HOUR_MIN = 60;

/** The shuttle's name. Before it is known, "Shuttle": its id is nothing to people. */
export function vehicleName(ride: RideTracker): string {
  const known = ride.vehicle.value?.facts.name ?? ride.ticket.value?.vehicle_name;
  return known || texts.value.shuttle;
}

/** The title without times. A screen reader announces it, so it changes only when the state does. */
export function titleText(phase: RidePhase, vehicle: string): string {
  const text = texts.value[phase];
  return typeof text === "string" ? text : text(vehicle);
}

/** What is announced: the title without times, or that the shuttle stands. */
export function announcedText({ state, phase }: RideProgress, vehicle: string): string {
  const t = texts.value;
  if (state.kind === "stopped") return t.stopped(vehicle);
  return state.kind === "late" ? t.late(vehicle) : titleText(phase, vehicle);
}

/** The title with its time, which changes every minute. */
export function titleWithTime(
  ride: RideTracker,
  { state, phase }: RideProgress,
  timezone: string,
): string {
  const name = vehicleName(ride);
  const now_ms = nowOf(ride);
  if (state.kind === "stopped") return texts.value.stopped(name);
  if (state.kind !== "unknown") return presentTitle(state, phase, name, now_ms, timezone);
  const is_unreachable = ride.link.state.value === "open" && ride.vehicle.value !== null;
  if (is_unreachable) return texts.value.unreachable(name);
  return pastTitle(state.last, phase, name, now_ms, timezone);
}

function presentTitle(
  state: Exclude<PresentRideState, Stopped>,
  phase: RidePhase,
  name: string,
  now_ms: number,
  timezone: string,
): string {
  const t = texts.value;
  switch (state.kind) {
    case "booked":
      return state.at_ms === null ? t.booked : t.booked_for(time(state.at_ms, now_ms, timezone));
    case "expected":
    case "late": {
      const { earliest_ms, latest_ms } = state;
      if (earliest_ms === null || latest_ms === null) return titleText(phase, name);
      if (minutesUntil(earliest_ms, now_ms) >= HOUR_MIN)
        return pastTitle(state, phase, name, now_ms, timezone);
      const minutes = minutesText(earliest_ms, latest_ms, now_ms);
      return state.kind === "late" ? t.late_in(name, minutes) : t.approaching_in(name, minutes);
    }
    case "aboard": {
      const { earliest_ms, latest_ms } = state;
      if (earliest_ms === null || latest_ms === null) return titleText(phase, name);
      if (minutesUntil(earliest_ms, now_ms) >= HOUR_MIN)
        return pastTitle(state, phase, name, now_ms, timezone);
      return t.aboard_in(minutesText(earliest_ms, latest_ms, now_ms));
    }
    default:
      return titleText(phase, name);
  }
}

/** With times of day: a time may stand there without news, but nothing counts down. */
function pastTitle(
  state: PresentRideState,
  phase: RidePhase,
  name: string,
  now_ms: number,
  timezone: string,
): string {
  const t = texts.value;
  if (state.kind === "expected" || state.kind === "late") {
    const { earliest_ms, latest_ms } = state;
    if (earliest_ms === null || latest_ms === null) return titleText(phase, name);
    const [from, to] = [earliest_ms, latest_ms].map((ms) => time(ms, now_ms, timezone));
    return from === to ? t.approaching_at(name, from!) : t.approaching_between(name, from!, to!);
  }
  if (state.kind === "aboard" && state.earliest_ms !== null && state.latest_ms !== null) {
    const [from, to] = [state.earliest_ms, state.latest_ms].map((ms) => time(ms, now_ms, timezone));
    return from === to ? t.aboard_at(from!) : t.aboard_between(from!, to!);
  }
  return titleText(phase, name);
}

/** "in 3 to 6 minutes": the earlier end rounded down, the later one up. */
export function minutesText(earliest_ms: number, latest_ms: number, now_ms: number): string {
  const t = texts.value;
  const from = minutesUntil(earliest_ms, now_ms);
  const is_range = latest_ms > earliest_ms;
  const to = is_range ? minutesUntilAtMost(latest_ms, now_ms) : from;
  if (to <= 1 && from === 0) return is_range && to === 1 ? t.in_at_most_a_minute : t.under_a_minute;
  if (from === 0) return t.in_at_most(to);
  return from === to ? t.in_minutes(from) : t.in_minutes_range(from, to);
}

/** The page's title while it is not looked at: "3–6 min", "here", "next stop"; "" for the usual one. */
export function shortText(state: RideState, now_ms: number): string {
  const t = texts.value;
  switch (state.kind) {
    case "expected":
    case "late": {
      if (state.earliest_ms === null || state.latest_ms === null) return "";
      const from = minutesUntil(state.earliest_ms, now_ms);
      if (from >= HOUR_MIN) return "";
      return t.short_minutes(from, Math.max(1, minutesUntilAtMost(state.latest_ms, now_ms)));
    }
    case "at_stop":
      return t.short_here;
    case "aboard":
      return state.is_next ? t.short_next_stop : "";
    case "at_destination":
      return t.short_arrived;
    case "stopped":
      return t.short_stopped;
    default:
      return "";
  }
}

/** The server's clock; read together with the page's, so that texts stay current. */
export function nowOf(ride: RideTracker): number {
  return monotonic_ms.value > 0 ? (ride.link.now_ms() ?? serverNow_ms()) : serverNow_ms();
}

function time(time_ms: number, now_ms: number, timezone: string): string {
  return formatTimeOrDateTime(time_ms, now_ms, language.value, timezone);
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

/** Why the shuttle stands, since when, and what happens next; "" while it does not, or nothing is known of it. */
export function delayText(
  ride: RideTracker,
  { state, phase }: RideProgress,
  timezone: string,
): string {
  const t = texts.value;
  if (state.kind === "unknown") {
    const is_silent = ride.link.state.value === "open" && ride.vehicle.value !== null;
    return is_silent ? t.vehicle_offline : "";
  }
  if (state.kind !== "stopped") return "";
  const clock = (time_ms: number) => formatTime(time_ms, language.value, timezone);
  return [
    t.stopped_because[state.cause],
    state.since_ms === null ? "" : t.stopped_since(clock(state.since_ms)),
    state.next === "resumes_at"
      ? t.resumes_at(clock(state.resumes_ms))
      : t.stopped_next[state.next],
    phase === "approaching" ? t.another_may_come : "",
  ]
    .filter((text) => text !== "")
    .join(language.value === "en" ? " " : "");
}
