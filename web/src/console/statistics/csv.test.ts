import { expect, test } from "vitest";
import { csvOf } from "./csv";

test("commas, quotes and line breaks stay in their cell", () => {
  expect(csvOf(["a", "b"], [['x, "y"', "1\n2"]])).toBe('a,b\r\n"x, ""y""","1\n2"\r\n');
});

test("a name does not become a formula, a negative number stays one", () => {
  expect(csvOf(["a"], [["=1+1"], [-3]])).toBe("a\r\n'=1+1\r\n-3\r\n");
});
