import { chooseLanguage, language } from "../texts/language";

/** Each language is named in that language, so that its speakers can read it. */
export function LanguageSwitch() {
  return (
    <div class="switch" role="group" aria-label="Language / 语言">
      <button
        type="button"
        lang="en"
        aria-pressed={language.value === "en"}
        onClick={() => chooseLanguage("en")}
      >
        EN
      </button>
      <button
        type="button"
        lang="zh-CN"
        aria-pressed={language.value === "zh-CN"}
        onClick={() => chooseLanguage("zh-CN")}
      >
        中文
      </button>
    </div>
  );
}
