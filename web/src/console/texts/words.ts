import { computed } from "@preact/signals";
import { language } from "../../shared/words/language";
import { en } from "./words_en";
import { zh } from "./words_zh";

export const words = computed(() => (language.value === "en" ? en : zh));
