import { expect, test } from "vitest";
import { hardTexts, textEntries } from "../../shared/texts/text_entries";
import { en } from "./texts_en";
import { zh } from "./texts_zh";

const [english, chinese] = [textEntries(en), textEntries(zh)];

test("every text exists in both languages", () => {
  const keys = (entries: [string, string][]) => entries.map(([key]) => key).sort();
  expect(keys(chinese)).toEqual(keys(english));
  for (const [, text] of [...english, ...chinese]) expect(text.trim()).not.toBe("");
});

test("no Chinese text is the English one", () => {
  const texts = new Map(english);
  expect(chinese.filter(([key, text]) => texts.get(key) === text)).toEqual([]);
});

test("English texts have short sentences and plain words", () => {
  expect(hardTexts(en)).toEqual([]);
});
