import type { Language } from "./preference";

type Moment = string | number;

/** "09:14", on the campus's clocks. */
export function clockTime(moment: Moment, language: Language, timezone: string): string {
  return format(moment, language, timezone, { hour: "2-digit", minute: "2-digit" });
}

/** "09:14:31" */
export function clockSeconds(moment: Moment, language: Language, timezone: string): string {
  const seconds = { hour: "2-digit", minute: "2-digit", second: "2-digit" } as const;
  return format(moment, language, timezone, seconds);
}

/** "Tue 1 Sept, 09:14" */
export function dayAndTime(moment: Moment, language: Language, timezone: string): string {
  const day = { weekday: "short", day: "numeric", month: "short" } as const;
  return format(moment, language, timezone, { ...day, hour: "2-digit", minute: "2-digit" });
}

/** The time alone today, with its day otherwise. */
export function momentNear(
  moment: Moment,
  now: Moment,
  language: Language,
  timezone: string,
): string {
  const day = { year: "numeric", month: "numeric", day: "numeric" } as const;
  const same = format(moment, "en", timezone, day) === format(now, "en", timezone, day);
  return same ? clockTime(moment, language, timezone) : dayAndTime(moment, language, timezone);
}

function format(
  moment: Moment,
  language: Language,
  timezone: string,
  options: Intl.DateTimeFormatOptions,
): string {
  const locale = language === "en" ? "en-GB" : language;
  return new Intl.DateTimeFormat(locale, {
    ...options,
    timeZone: timezone,
    hourCycle: "h23",
  }).format(new Date(moment));
}

/** "Mon" for 0, "Sun" for 6. */
export function weekdayName(day: number, language: Language, width: "short" | "long"): string {
  const locale = language === "en" ? "en-GB" : language;
  const in_that_week = Date.UTC(2024, 0, 1 + day, 12);
  return new Intl.DateTimeFormat(locale, { weekday: width, timeZone: "UTC" }).format(in_that_week);
}

/** "2026-09-01": the campus's day at that moment. */
export function calendarDay(moment_ms: number, timezone: string): string {
  return toLocalInput(moment_ms, timezone).slice(0, 10);
}

/** What <input type="datetime-local"> wants, on the campus's clocks. */
export function toLocalInput(moment_ms: number, timezone: string): string {
  const parts = partsOf(moment_ms, timezone);
  return `${parts["year"]}-${parts["month"]}-${parts["day"]}T${parts["hour"]}:${parts["minute"]}`;
}

/** The moment that a campus clock shows; null for text that is no time. */
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
  // Around a change of the clocks the first guess may have used the wrong side's offset.
  return new Date(wanted_ms - offset_ms(guess_ms, timezone));
}

function offset_ms(moment_ms: number, timezone: string): number {
  const parts = partsOf(moment_ms, timezone);
  const number = (name: string) => Number(parts[name]);
  const shown_ms = Date.UTC(
    number("year"),
    number("month") - 1,
    number("day"),
    number("hour"),
    number("minute"),
    number("second"),
  );
  return shown_ms - Math.floor(moment_ms / 1000) * 1000;
}

function partsOf(moment_ms: number, timezone: string): Record<string, string> {
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
  return Object.fromEntries(format.formatToParts(moment_ms).map((part) => [part.type, part.value]));
}
