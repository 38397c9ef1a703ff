import { signal } from "@preact/signals";
import type { Schemas } from "../api/client";
import { api, resultOf } from "../api/client";
import type { Problem } from "../api/problem";
import type { CampusGeometry } from "./campus_geometry";
import { campusGeometry } from "./campus_geometry";

export interface Campus {
  readonly view: Schemas["CampusView"];
  readonly geometry: CampusGeometry;
}

export const campus = signal<Campus | null>(null);
export const campusProblem = signal<Problem | null>(null);

/** Loads the campus and its map, at the start and after a change of the map. */
export async function loadCampus(): Promise<void> {
  campusProblem.value = null;
  const [view, geometry] = await Promise.all([
    resultOf(api.GET("/api/v1/campus")),
    resultOf(api.GET("/api/v1/campus/map")),
  ]);
  if (!view.ok) campusProblem.value = view.problem;
  else if (!geometry.ok) campusProblem.value = geometry.problem;
  else campus.value = { view: view.value, geometry: campusGeometry(geometry.value) };
}
