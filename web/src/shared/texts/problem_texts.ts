import type { Language } from "./preference";

/** What each problem of the API means for the user, by its code. Pages add the languages that they have loaded. */
const PROBLEMS: Record<Language, Record<string, string>> = { en: {}, "zh-CN": {} };

export function addProblemTexts(language: Language, texts: Readonly<Record<string, string>>): void {
  Object.assign(PROBLEMS[language], texts);
}

/** The text for a problem's code; null for an unknown code, whose detail by the server is shown instead. */
export function problemText(code: string, language: Language): string | null {
  return PROBLEMS[language][code] ?? null;
}

export function problemCodes(language: Language): readonly string[] {
  return Object.keys(PROBLEMS[language]);
}
