/** Days of the campus, in its own timezone: on two of them a year the clocks are changed. */

/** When a day begins, in milliseconds since the Unix epoch. date: "2026-10-25". */
export function startOfDay_ms(date: string, timezone: string): number {
  const wall_ms = Date.parse(`${date}T00:00:00Z`);
  // The offset is that of the moment itself, which the first guess may miss by the change of a clock.
  const first_ms = wall_ms - offset_ms(wall_ms, timezone);
  return wall_ms - offset_ms(first_ms, timezone);
}

/** The day after, "2026-10-26". */
export function dayAfter(date: string): string {
  return daysLater(date, 1);
}

/** The day so many days later, or earlier for a negative number. */
export function daysLater(date: string, count: number): string {
  return new Date(Date.parse(`${date}T00:00:00Z`) + count * 86_400_000).toISOString().slice(0, 10);
}

/** The day of a moment, "2026-10-25". */
export function dayOf(at_ms: number, timezone: string): string {
  return new Date(at_ms + offset_ms(at_ms, timezone)).toISOString().slice(0, 10);
}

/** How far the timezone's clocks are ahead of UTC. */
function offset_ms(at_ms: number, timezone: string): number {
  const parts = new Intl.DateTimeFormat("en-GB", {
    timeZone: timezone,
    hourCycle: "h23",
    year: "numeric",
    month: "2-digit",
    day: "2-digit",
    hour: "2-digit",
    minute: "2-digit",
    second: "2-digit",
  }).formatToParts(at_ms);
  const part = (type: string) => Number(parts.find((each) => each.type === type)?.value);
  const wall_ms = Date.UTC(
    part("year"),
    part("month") - 1,
    part("day"),
    part("hour"),
    part("minute"),
    part("second"),
  );
  return wall_ms - Math.floor(at_ms / 1000) * 1000;
}
