import type { Language } from "./preference";

type Timestamp = string | number;

/** "09:14", in the campus's timezone. */
export function formatTime(timestamp: Timestamp, language: Language, timezone: string): string {
  return format(timestamp, language, timezone, { hour: "2-digit", minute: "2-digit" });
}

/** "09:14:31" */
export function formatTimeWithSeconds(
  timestamp: Timestamp,
  language: Language,
  timezone: string,
): string {
  const seconds = { hour: "2-digit", minute: "2-digit", second: "2-digit" } as const;
  return format(timestamp, language, timezone, seconds);
}

/** "Tue 1 Sept, 09:14" */
export function formatDateTime(timestamp: Timestamp, language: Language, timezone: string): string {
  const day = { weekday: "short", day: "numeric", month: "short" } as const;
  return format(timestamp, language, timezone, { ...day, hour: "2-digit", minute: "2-digit" });
}

/** The time alone if it is on the same day as `now`, else with its date. */
export function formatTimeOrDateTime(
  timestamp: Timestamp,
  now: Timestamp,
  language: Language,
  timezone: string,
): string {
  const day = { year: "numeric", month: "numeric", day: "numeric" } as const;
  const is_same_day = format(timestamp, "en", timezone, day) === format(now, "en", timezone, day);
  return is_same_day
    ? formatTime(timestamp, language, timezone)
    : formatDateTime(timestamp, language, timezone);
}

function format(
  timestamp: Timestamp,
  language: Language,
  timezone: string,
  options: Intl.DateTimeFormatOptions,
): string {
  return new Intl.DateTimeFormat(localeOf(language), {
    ...options,
    timeZone: timezone,
    hourCycle: "h23",
  }).format(new Date(timestamp));
}

/** "Thu 1 Oct" of "2026-10-01": a date without an hour, the same in every timezone. */
export function formatDate(date: string, language: Language, year?: "numeric"): string {
  return new Intl.DateTimeFormat(localeOf(language), {
    weekday: "short",
    day: "numeric",
    month: "short",
    year,
    timeZone: "UTC",
  }).format(new Date(`${date}T12:00:00Z`));
}

/** "Mon" for 0, "Sun" for 6. */
export function weekdayName(day: number, language: Language, width: "short" | "long"): string {
  const noon_ms = Date.UTC(2024, 0, 1 + day, 12);
  const options = { weekday: width, timeZone: "UTC" } as const;
  return new Intl.DateTimeFormat(localeOf(language), options).format(noon_ms);
}

function localeOf(language: Language): string {
  return language === "en" ? "en-GB" : language;
}

/** "2026-09-01": the campus's date at a time. */
export function isoDate(timestamp_ms: number, timezone: string): string {
  return toLocalInput(timestamp_ms, timezone).slice(0, 10);
}

/** A time in the campus's timezone, in the format of <input type="datetime-local">. */
export function toLocalInput(timestamp_ms: number, timezone: string): string {
  const parts = partsOf(timestamp_ms, timezone);
  return `${parts["year"]}-${parts["month"]}-${parts["day"]}T${parts["hour"]}:${parts["minute"]}`;
}

/** The time that such a text means in the campus's timezone; null for a text that is no time. */
export function fromLocalInput(text: string, timezone: string): Date | null {
  const match = /^(\d{4})-(\d\d)-(\d\d)T(\d\d):(\d\d)/.exec(text);
  if (match === null) return null;
  const [year, month, day, hour, minute] = match.slice(1).map(Number) as [
    number,
    number,
    number,
    number,
    number,
  ];
  const wanted_ms = Date.UTC(year, month - 1, day, hour, minute);
  const guess_ms = wanted_ms - offset_ms(wanted_ms, timezone);
  // Near a change to or from summer time the guess may have the offset of the other side.
  return new Date(wanted_ms - offset_ms(guess_ms, timezone));
}

function offset_ms(timestamp_ms: number, timezone: string): number {
  const parts = partsOf(timestamp_ms, timezone);
  const number = (name: string) => Number(parts[name]);
  const shown_ms = Date.UTC(
    number("year"),
    number("month") - 1,
    number("day"),
    number("hour"),
    number("minute"),
    number("second"),
  );
  return shown_ms - Math.floor(timestamp_ms / 1000) * 1000;
}

function partsOf(timestamp_ms: number, timezone: string): Record<string, string> {
  const format = new Intl.DateTimeFormat("en-GB", {
    timeZone: timezone,
    hourCycle: "h23",
    year: "numeric",
    month: "2-digit",
    day: "2-digit",
    hour: "2-digit",
    minute: "2-digit",
    second: "2-digit",
  });
  return Object.fromEntries(
    format.formatToParts(timestamp_ms).map((part) => [part.type, part.value]),
  );
}
