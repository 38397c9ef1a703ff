import { expect, test } from "vitest";
import { preferredLanguage } from "./preference";

test("the stored language wins, then the browser's, then English", () => {
  expect(preferredLanguage("zh-CN", ["en-US"])).toBe("zh-CN");
  expect(preferredLanguage(null, ["fr", "zh-TW", "en"])).toBe("zh-CN");
  expect(preferredLanguage("klingon", ["fr"])).toBe("en");
});
