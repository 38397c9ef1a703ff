import { expect, test } from "vitest";
import { entriesOf } from "../../shared/words/entries";
import { en } from "./words_en";
import { zh } from "./words_zh";

const [english, chinese] = [entriesOf(en), entriesOf(zh)];

test("every word is there in both languages", () => {
  const keys = (entries: [string, string][]) => entries.map(([key]) => key).sort();
  expect(keys(chinese)).toEqual(keys(english));
  for (const [, text] of [...english, ...chinese]) expect(text.trim()).not.toBe("");
});

test("no English is left among the Chinese", () => {
  const texts = new Map(english);
  expect(chinese.filter(([key, text]) => texts.get(key) === text)).toEqual([]);
});
