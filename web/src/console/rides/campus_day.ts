/** The begin and end of a day (YYYY-MM-DD) in a timezone, as instants. */
export function dayBounds(day: string, timezone: string): { since: string; before: string } {
  const begin_ms = Date.parse(`${day}T00:00:00Z`);
  return {
    since: new Date(begin_ms - offsetAt_ms(begin_ms, timezone)).toISOString(),
    before: new Date(begin_ms + DAY_MS - offsetAt_ms(begin_ms + DAY_MS, timezone)).toISOString(),
  };
}

const DAY_MS = 86_400_000;

/** How far the timezone's clock is ahead of UTC when that clock shows the time `local_ms`. */
function offsetAt_ms(local_ms: number, timezone: string): number {
  const guess_ms = clockOf_ms(local_ms, timezone) - local_ms;
  return clockOf_ms(local_ms - guess_ms, timezone) - (local_ms - guess_ms);
}

function clockOf_ms(instant_ms: number, timezone: string): number {
  const parts = new Intl.DateTimeFormat("en-GB", {
    timeZone: timezone,
    hourCycle: "h23",
    year: "numeric",
    month: "2-digit",
    day: "2-digit",
    hour: "2-digit",
    minute: "2-digit",
    second: "2-digit",
  }).formatToParts(instant_ms);
  const of = (type: string) => parts.find((part) => part.type === type)!.value;
  return Date.parse(
    `${of("year")}-${of("month")}-${of("day")}T${of("hour")}:${of("minute")}:${of("second")}Z`,
  );
}
