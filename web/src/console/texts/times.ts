import { campus } from "../../shared/campus/campus";
import { language } from "../../shared/texts/language";
import { clockSeconds, clockTime, dayAndTime, momentNear } from "../../shared/texts/times";
import { link } from "../session";

function timezone(): string {
  return campus.value?.view.timezone ?? "UTC";
}

/** The server's clock, or this screen's while the server has not been heard. */
export function now_ms(): number {
  return link.value?.now_ms() ?? Date.now();
}

export const clock = (moment: string | number) => clockTime(moment, language.value, timezone());
export const seconds = (moment: string | number) =>
  clockSeconds(moment, language.value, timezone());
export const day = (moment: string | number) => dayAndTime(moment, language.value, timezone());
export const near = (moment: string | number) =>
  momentNear(moment, now_ms(), language.value, timezone());

/** "Thu 1 Oct 2026": a date without an hour, the same wherever it is read. */
export function calendarDate(date: string): string {
  return new Intl.DateTimeFormat(language.value === "en" ? "en-GB" : language.value, {
    weekday: "short",
    day: "numeric",
    month: "short",
    year: "numeric",
    timeZone: "UTC",
  }).format(new Date(`${date}T12:00:00Z`));
}
