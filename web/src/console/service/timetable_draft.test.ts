import { expect, test } from "vitest";
import type { Trip } from "./timetable_draft";
import { withTrip } from "./timetable_draft";

const trip = (trip_id: string, ...times: readonly string[]): Trip => ({
  trip_id,
  service_id: "",
  calls: times.map((leaves, number) => ({ stop_id: `stop-${number}`, leaves })),
});

test("a trip takes the place of the one that was edited, in the order of the day", () => {
  const trips = [trip("a", "08:00", "08:10"), trip("b", "09:00", "09:10")];
  const ids = (changed: readonly Trip[]) => changed.map(({ trip_id }) => trip_id);
  expect(ids(withTrip(trips, trip("a2", "10:00", "10:10"), "a"))).toEqual(["b", "a2"]);
  expect(ids(withTrip(trips, trip("c", "08:30", "08:40"), null))).toEqual(["a", "c", "b"]);
  expect(ids(trips)).toEqual(["a", "b"]);
});
