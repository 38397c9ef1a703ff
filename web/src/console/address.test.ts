import { expect, test } from "vitest";
import { fragmentOf, placeFrom } from "./address";

test("a place and its fragment are each other's inverse", () => {
  expect(placeFrom(fragmentOf("runs", "shuttle-1", "boot/7 a"))).toEqual({
    page: "runs",
    parts: ["shuttle-1", "boot/7 a"],
  });
});

test.each(["", "#", "#/", "#/nowhere"])("'%s' is the live page", (fragment) => {
  expect(placeFrom(fragment).page).toBe("live");
});
