import { signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { Stop } from "../../shared/campus/campus_geometry";

/** What a passenger needs to book. The map, a hundred times larger, comes afterwards. */
export interface Campus {
  readonly view: Schemas["CampusView"];
  readonly stops: readonly Stop[];
}

export const campus = signal<Campus | null>(null);
export const campusProblem = signal<Problem | null>(null);

/** Loads the campus and its stops, at the start and after a change of the map. */
export async function loadCampus(): Promise<void> {
  campusProblem.value = null;
  const [view, stops] = await Promise.all([
    resultOf(api.GET("/api/v1/campus")),
    resultOf(api.GET("/api/v1/stops")),
  ]);
  if (!view.ok) campusProblem.value = view.problem;
  else if (!stops.ok) campusProblem.value = stops.problem;
  else campus.value = { view: view.value, stops: stops.value };
}
