import { expect, test } from "vitest";
import { matchingEntries, rideCodeIn } from "./palette_entries";

const ENTRIES = ["Go to Rides", "Shuttle 1", "Shuttle 12", "Show rides"].map((name) => ({
  name,
  run: () => undefined,
}));

const names = (query: string) => matchingEntries(ENTRIES, query).map((entry) => entry.name);

test("every term must be there, and what begins with the query comes first", () => {
  expect(names("shuttle 1")).toEqual(["Shuttle 1", "Shuttle 12"]);
  expect(names("rides go")).toEqual(["Go to Rides"]);
  expect(names("show")).toEqual(["Show rides"]);
  expect(names("")).toHaveLength(4);
  expect(names("nothing")).toEqual([]);
});

test("a ride's code is recognized however it is written", () => {
  expect(rideCodeIn("k7m q2x")).toBe("K7MQ2X");
  expect(rideCodeIn("K7M-Q2X")).toBe("K7MQ2X");
  expect(rideCodeIn("K7MQ2")).toBeNull();
  expect(rideCodeIn("shuttle 1")).toBeNull();
});
