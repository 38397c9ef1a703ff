import { signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Answer } from "../../shared/api/problem";
import { toLocalInput } from "../../shared/texts/times";
import { destination, party, pickup, randomKey, wheelchairs } from "./ride_request";

/** On which days a ride shall be repeated: 0 is Monday, as everywhere. */
export const repeating = signal(false);
export const weekdays = signal<readonly number[]>([0, 1, 2, 3, 4]);
/** Campus local time and day, as the inputs hold them. */
export const leave = signal("08:10");
export const ends_on = signal("");

const WEEKS_AT_FIRST = 4;
export const DAYS_MAX = 365;
const DAY_MS = 86_400_000;

export function toggleWeekday(day: number): void {
  const chosen = weekdays.value;
  weekdays.value = chosen.includes(day)
    ? chosen.filter((other) => other !== day)
    : [...chosen, day].sort();
}

export function startRepeating(timezone: string): void {
  repeating.value = true;
  if (ends_on.value === "") ends_on.value = dayAfter(WEEKS_AT_FIRST * 7, timezone);
}

/** The campus's day so many days from now, as a date input wants it. */
export function dayAfter(days: number, timezone: string): string {
  return toLocalInput(Date.now() + days * DAY_MS, timezone).slice(0, 10);
}

export function repeatIsUsable(timezone: string): boolean {
  return (
    weekdays.value.length > 0 &&
    /^\d\d:\d\d$/.test(leave.value) &&
    ends_on.value >= dayAfter(0, timezone)
  );
}

let attempt: { readonly wish: string; readonly key: string } | null = null;

/** As `book`: a repeat after a lost answer cannot end in two recurring bookings. */
export async function bookSeries(): Promise<Answer<Schemas["SeriesTicket"]>> {
  const body = {
    from_stop: pickup.value,
    to_stop: destination.value,
    party: party.value,
    wheelchairs: wheelchairs.value,
    weekdays: [...weekdays.value],
    leave: leave.value,
    ends_on: ends_on.value,
  };
  const wish = JSON.stringify(body);
  if (attempt?.wish !== wish) attempt = { wish, key: randomKey() };
  const answer = await answerOf(
    api.POST("/api/v1/series", { body, params: { header: { "idempotency-key": attempt.key } } }),
  );
  if (answer.ok) attempt = null;
  return answer;
}
