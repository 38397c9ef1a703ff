import { expect, test } from "vitest";
import type { Schemas } from "../../shared/api/client";
import { groupIncidents } from "./incident_groups";

type Incident = Schemas["IncidentView"];

function anIncident(
  incident_id: string,
  kind: Incident["kind"],
  vehicle_id: string | null,
): Incident {
  return {
    incident_id,
    kind,
    vehicle_id,
    priority: 20,
    cause: "",
    opened_at: "2026-11-25T08:00:00Z",
    ride_id: null,
    acknowledged_at: null,
    acknowledged_by: "",
    closed_at: null,
    closed_by: "",
  };
}

const SORTED = [
  anIncident("a", "help_call", "shuttle-2"),
  anIncident("b", "vehicle_fault", "shuttle-1"),
  anIncident("c", "vehicle_fault", "shuttle-2"),
  anIncident("d", "server_degraded", null),
];

const idsOf = (by: "kind" | "vehicle") =>
  groupIncidents(SORTED, by).map(({ key, incidents }) => [
    key,
    incidents.map((incident) => incident.incident_id),
  ]);

test("the most urgent group comes first, and each keeps its order", () => {
  expect(idsOf("kind")).toEqual([
    ["help_call", ["a"]],
    ["vehicle_fault", ["b", "c"]],
    ["server_degraded", ["d"]],
  ]);
  expect(idsOf("vehicle")).toEqual([
    ["shuttle-2", ["a", "c"]],
    ["shuttle-1", ["b"]],
    ["", ["d"]],
  ]);
});
