import { signal } from "@preact/signals";
import type { Language } from "../shared/texts/language";
import type { Announcement } from "./screen_scene";

/** Whether this screen speaks; off until a passenger turns it on, since the shuttle has a loudspeaker too. */
export const is_speaking = signal(false);
export const can_speak = "speechSynthesis" in window;

let last_number = 0;

/** Speaks the newest announcement, once. */
export function speakNewest(announcements: readonly Announcement[], language: Language): void {
  const newest = announcements.at(-1);
  if (newest === undefined || newest.number === last_number) return;
  last_number = newest.number;
  if (!is_speaking.peek() || !can_speak) return;
  const text = language === "en" ? newest.text || newest.text_zh : newest.text_zh || newest.text;
  const utterance = new SpeechSynthesisUtterance(text);
  utterance.lang = language;
  speechSynthesis.speak(utterance);
}
