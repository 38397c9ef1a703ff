import type { Language } from "../shared/texts/language";
import { formatTime } from "../shared/texts/times";
import type { BoardTexts } from "./texts/texts_en";

interface Range {
  readonly earliest: string;
  readonly latest: string;
}

interface Moment {
  readonly now_ms: number;
  readonly language: Language;
  readonly timezone: string;
}

/** Further ahead a time of day says more than minutes. */
const MINUTES_MAX = 30;

/** "3–5 min", "Now", or the times of day of a pickup that is far ahead. */
export function rangeText(range: Range, at: Moment, t: BoardTexts): string {
  const ahead_s = (moment: string) => Math.max(0, (Date.parse(moment) - at.now_ms) / 1000);
  const from = Math.floor(ahead_s(range.earliest) / 60);
  const to = Math.ceil(ahead_s(range.latest) / 60);
  if (from > MINUTES_MAX) {
    const time = (moment: string) => formatTime(moment, at.language, at.timezone);
    return t.between(time(range.earliest), time(range.latest));
  }
  if (to <= 1) return t.any_moment;
  return from === to ? t.minutes(to) : t.minutes_between(from, to);
}
