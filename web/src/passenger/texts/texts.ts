import { batch, computed, signal } from "@preact/signals";
import { chooseLanguage } from "../../shared/texts/language";
import type { Language } from "../../shared/texts/preference";
import { addProblemTexts } from "../../shared/texts/problem_texts";
import type { PassengerTexts } from "./texts_en";

/** Each language is a file of its own: a phone loads the one that its passenger reads. */
const FILES: Record<Language, () => Promise<LanguageFile>> = {
  en: () => import("./english"),
  "zh-CN": () => import("./chinese"),
};

interface LanguageFile {
  readonly texts: PassengerTexts;
  readonly problems: Readonly<Record<string, string>>;
}

const shown = signal<PassengerTexts | null>(null);

/** The texts in the chosen language. The page is drawn when they have come. */
export const texts = computed(() => {
  if (shown.value === null) throw new Error("the texts have not come yet");
  return shown.value;
});

/** A language's file did not come: the page stays in the one that it has. */
export const isLanguageMissing = signal(false);

/** Shows the texts of a language. Returns false if its file did not come. */
export async function showLanguage(language: Language): Promise<boolean> {
  return show(language, () => undefined);
}

/** The page changes its language when the texts are there, so that none is announced in the wrong one. */
export async function switchLanguage(language: Language): Promise<void> {
  await show(language, () => chooseLanguage(language));
}

async function show(language: Language, andThen: () => void): Promise<boolean> {
  const file = await FILES[language]().catch((error: unknown) => {
    console.info("the texts did not come", error);
    return null;
  });
  batch(() => {
    isLanguageMissing.value = file === null;
    if (file === null) return;
    addProblemTexts(language, file.problems);
    shown.value = file.texts;
    andThen();
  });
  return file !== null;
}
