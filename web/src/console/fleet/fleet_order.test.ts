import { expect, test } from "vitest";
import { aVehicle } from "../../shared/scene/scene_builders";
import { inNaturalOrder, matchesQuery, passesFilter } from "./fleet_order";

const named = (name: string) => aVehicle({ vehicle_id: name, name });

test("shuttle 2 stands before shuttle 10", () => {
  const names = ["Shuttle 10", "Shuttle 1", "Bus 3", "Shuttle 100", "shuttle 2"];
  const ordered = inNaturalOrder(names.map(named)).map((vehicle) => vehicle.facts.name);
  expect(ordered).toEqual(["Bus 3", "Shuttle 1", "shuttle 2", "Shuttle 10", "Shuttle 100"]);
});

test("a filter keeps what needs the same attention", () => {
  expect(passesFilter(aVehicle({ held: true }), "warning")).toBe(true);
  expect(passesFilter(aVehicle({ held: true }), "danger")).toBe(false);
  expect(passesFilter(aVehicle({ in_service: false }), "out_of_service")).toBe(true);
  expect(passesFilter(aVehicle({ connected: false }), "danger")).toBe(true);
});

test("a search looks at names, states and stops", () => {
  const vehicle = aVehicle({ name: "Shuttle 7", next_stop: "stop-1", held: true });
  const found = (query: string) =>
    matchesQuery(
      vehicle,
      query,
      (condition) => (condition === "held" ? "Held" : "other"),
      () => "Main Library",
    );
  expect(found("")).toBe(true);
  expect(found("7 held")).toBe(true);
  expect(found("library")).toBe(true);
  expect(found("8")).toBe(false);
});
