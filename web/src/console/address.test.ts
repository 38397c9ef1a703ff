import { expect, test } from "vitest";
import { addressFrom, fragmentOf } from "./address";

test("an address and its fragment are each other's inverse", () => {
  expect(addressFrom(fragmentOf("runs", "shuttle-1", "boot/7 a"))).toEqual({
    page: "runs",
    ids: ["shuttle-1", "boot/7 a"],
  });
});

test.each(["", "#", "#/", "#/nowhere"])("'%s' is the live page", (fragment) => {
  expect(addressFrom(fragment).page).toBe("live");
});
