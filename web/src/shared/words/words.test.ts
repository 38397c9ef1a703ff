import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { en as consoleEn } from "../../console/words_en";
import { zh as consoleZh } from "../../console/words_zh";
import { en as passengerEn } from "../../passenger/words_en";
import { zh as passengerZh } from "../../passenger/words_zh";
import { preferredLanguage } from "./preference";
import { problemCodes } from "./problem_words";

type Words = Readonly<Record<string, unknown>>;

/** Every key with its spoken example, nested ones as "group.key". */
function spoken(words: Words, prefix = ""): [string, string][] {
  return Object.entries(words).flatMap(([key, value]): [string, string][] => {
    if (typeof value === "string") return [[prefix + key, value]];
    if (typeof value === "function") return [[prefix + key, String(value(7, 8))]];
    return spoken(value as Words, `${prefix}${key}.`);
  });
}

const dictionaries = [
  ["passenger", passengerEn, passengerZh],
  ["console", consoleEn, consoleZh],
] as const;

test.each(dictionaries)("the %s page has every word in both languages", (_, en, zh) => {
  const keys = (words: Words) => spoken(words).map(([key]) => key);
  expect(keys(zh).sort()).toEqual(keys(en).sort());
  for (const [, text] of [...spoken(en), ...spoken(zh)]) expect(text.trim()).not.toBe("");
});

/** Units and names that are written alike in both languages. */
const ALIKE = new Set(["kmh", "metres", "boards", "alights", "times", "megabytes"]);

test.each(dictionaries)("the %s page leaves no English among its Chinese", (_, en, zh) => {
  const english = new Map(spoken(en));
  const same = spoken(zh).filter(([key, text]) => english.get(key) === text && !ALIKE.has(key));
  expect(same).toEqual([]);
});

test("every refusal of the API that a page can meet has words in both languages", () => {
  const document = readFileSync(new URL("../../../openapi.json", import.meta.url), "utf8");
  const codes = new Set([...document.matchAll(/"code": "([a-z_]+)"/g)].map((match) => match[1]!));
  // Told to vehicles, uploads and scripts, which do not read our pages.
  const for_machines = [
    "key_invalid",
    "enrolment_code_unknown",
    "enrolment_code_used",
    "segment_conflict",
    "segment_hash_wrong",
    "segment_too_large",
    "segment_unreadable",
    "command_unknown",
    "token_invalid",
    "scope_missing",
    "signature_wrong",
  ];
  for (const language of ["en", "zh-CN"] as const) {
    const known = new Set(problemCodes(language));
    const missing = [...codes].filter((code) => !known.has(code) && !for_machines.includes(code));
    expect(missing).toEqual([]);
  }
  expect(problemCodes("zh-CN")).toEqual(problemCodes("en"));
  expect(codes.size).toBeGreaterThan(20);
});

test("the language chosen before wins, then the browser's, then English", () => {
  expect(preferredLanguage("zh-CN", ["en-US"])).toBe("zh-CN");
  expect(preferredLanguage(null, ["fr", "zh-TW", "en"])).toBe("zh-CN");
  expect(preferredLanguage("klingon", ["fr"])).toBe("en");
});
