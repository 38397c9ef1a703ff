import { effect, signal } from "@preact/signals";

export type Language = "en" | "zh-CN";

const KEY = "campusloop.language";

/** The language chosen before, else the browser's first one that we speak. */
export function preferredLanguage(stored: string | null, browser: readonly string[]): Language {
  if (stored === "en" || stored === "zh-CN") return stored;
  for (const tag of browser) {
    if (tag.startsWith("zh")) return "zh-CN";
    if (tag.startsWith("en")) return "en";
  }
  return "en";
}

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
