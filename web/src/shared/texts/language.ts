import { effect, signal } from "@preact/signals";
import type { Language } from "./preference";
import { preferredLanguage } from "./preference";

export type { Language };

const KEY = "campusloop.language";

export const language = signal<Language>(
  preferredLanguage(localStorage.getItem(KEY), navigator.languages),
);

effect(() => {
  document.documentElement.lang = language.value;
});

export function chooseLanguage(choice: Language): void {
  language.value = choice;
  localStorage.setItem(KEY, choice);
}
