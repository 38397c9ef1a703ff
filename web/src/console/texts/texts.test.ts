import { expect, test } from "vitest";
import { hardTexts, textEntries } from "../../shared/texts/text_entries";
import { announcementEn } from "./announcement_texts_en";
import { forkEn } from "./fork_texts_en";
import { localizationMapEn } from "./localization_map_texts_en";
import { onboardEn } from "./onboard_texts_en";
import { positionEn } from "./position_texts_en";
import { scanEn } from "./scan_texts_en";
import { recordingEn } from "./recording_texts_en";
import { replayEn } from "./replay_texts_en";
import { statisticsEn } from "./statistics_texts_en";
import { en } from "./texts_en";
import { zh } from "./texts_zh";

/** Texts of units, which are the same in both languages. */
const SAME = new Set(["kmh", "metres", "boards", "alights", "speed_factor", "megabytes"]);

const [english, chinese] = [textEntries(en), textEntries(zh)];

test("every text exists in both languages", () => {
  const keys = (entries: [string, string][]) => entries.map(([key]) => key).sort();
  expect(keys(chinese)).toEqual(keys(english));
  for (const [, text] of [...english, ...chinese]) expect(text.trim()).not.toBe("");
});

test("no text of a file of its own is covered by one of the same name", () => {
  for (const part of [
    announcementEn,
    forkEn,
    localizationMapEn,
    onboardEn,
    positionEn,
    recordingEn,
    scanEn,
    replayEn,
    statisticsEn,
  ])
    for (const [key, text] of Object.entries(part)) expect(en[key as keyof typeof en]).toBe(text);
});

test("no Chinese text is the English one", () => {
  const texts = new Map(english);
  const same = chinese.filter(([key, text]) => texts.get(key) === text && !SAME.has(key));
  expect(same).toEqual([]);
});

test("English texts have short sentences and plain words", () => {
  expect(hardTexts(en)).toEqual([]);
});
