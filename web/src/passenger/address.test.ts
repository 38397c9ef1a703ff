import { expect, test } from "vitest";
import type { Address } from "./address";
import { addressFrom, fragmentOf } from "./address";

const addresses: readonly Address[] = [
  { view: "book" },
  { view: "ride", token: "q3Jv0X2mQp7sT4uYb1cD9w" },
  { view: "find", code: "K7M Q2X" },
  { view: "series", token: "q3Jv0X2mQp7sT4uYb1cD9w" },
  { view: "timetable" },
];

test.each(addresses)("%o and its fragment are each other's inverse", (address) => {
  expect(addressFrom(fragmentOf(address))).toEqual(address);
});

test.each(["#ride=short", "#ride=<script>alert(1)</script>", "#ride", "#series=half"])(
  "%s is a broken link, and said to be one",
  (fragment) => {
    expect(addressFrom(fragment)).toEqual({ view: "broken_link" });
  },
);

test.each(["", "#", "#nonsense"])("%s opens the booking", (fragment) => {
  expect(addressFrom(fragment)).toEqual({ view: "book" });
});

test("a broken escape is no code", () => {
  expect(addressFrom("#code=%E0%A4%A")).toEqual({ view: "find", code: "" });
});
