import { serverNow_ms } from "../../shared/api/server_time";
import { signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import { toLocalInput } from "../../shared/texts/times";
import { idempotencyKey } from "../../shared/api/idempotency_key";
import { destination, party, pickup, wheelchairs } from "./ride_request";

export const isRecurring = signal(false);
/** The days on which the ride is repeated; 0 is Monday. */
export const weekdays = signal<readonly number[]>([0, 1, 2, 3, 4]);
/** Campus local time and date, as the inputs hold them. */
export const leave_time = signal("08:10");
export const ends_on = signal("");

const DEFAULT_WEEKS = 4;
export const DAYS_MAX = 365;
const DAY_MS = 86_400_000;

export function toggleWeekday(day: number): void {
  const days = weekdays.value;
  weekdays.value = days.includes(day)
    ? days.filter((other) => other !== day)
    : [...days, day].sort();
}

export function makeRecurring(timezone: string): void {
  isRecurring.value = true;
  if (ends_on.value === "") ends_on.value = dateInDays(DEFAULT_WEEKS * 7, timezone);
}

/** The campus's date in a number of days, in the format of a date input. */
export function dateInDays(days: number, timezone: string): string {
  return toLocalInput(serverNow_ms() + days * DAY_MS, timezone).slice(0, 10);
}

export function isSeriesRequestValid(timezone: string): boolean {
  return (
    weekdays.value.length > 0 &&
    /^\d\d:\d\d$/.test(leave_time.value) &&
    ends_on.value >= dateInDays(0, timezone)
  );
}

let attempt: { readonly request: string; readonly key: string } | null = null;

/** Books the series. As in `bookRide`, a request that is sent again does not book twice. */
export async function bookSeries(): Promise<Result<Schemas["SeriesTicket"]>> {
  const body = {
    from_stop: pickup.value,
    to_stop: destination.value,
    party: party.value,
    wheelchairs: wheelchairs.value,
    weekdays: [...weekdays.value],
    leave: leave_time.value,
    ends_on: ends_on.value,
  };
  const request = JSON.stringify(body);
  if (attempt?.request !== request) attempt = { request, key: idempotencyKey() };
  const result = await resultOf(
    api.POST("/api/v1/series", { body, params: { header: { "idempotency-key": attempt.key } } }),
  );
  if (result.ok) attempt = null;
  return result;
}
