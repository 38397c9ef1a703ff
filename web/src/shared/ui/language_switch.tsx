import { chooseLanguage, language } from "../texts/language";
import type { Language } from "../texts/language";

/** Each language is named in that language, so that its speakers can read it. */
export function LanguageSwitch({
  onChoose = chooseLanguage,
}: {
  readonly onChoose?: (choice: Language) => void;
}) {
  return (
    <div class="switch" role="group" aria-label="Language / 语言">
      <button
        type="button"
        lang="en"
        aria-pressed={language.value === "en"}
        onClick={() => onChoose("en")}
      >
        EN
      </button>
      <button
        type="button"
        lang="zh-CN"
        aria-pressed={language.value === "zh-CN"}
        onClick={() => onChoose("zh-CN")}
      >
        中文
      </button>
    </div>
  );
}
