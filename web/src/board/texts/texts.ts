import { computed } from "@preact/signals";
import { language } from "../../shared/texts/language";
import { en } from "./texts_en";
import { zh } from "./texts_zh";

export const texts = computed(() => (language.value === "en" ? en : zh));
