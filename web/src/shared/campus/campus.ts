import { signal } from "@preact/signals";
import type { Schemas } from "../api/client";
import { answerOf, api } from "../api/client";
import type { Problem } from "../api/problem";
import type { CampusShape } from "./campus_geometry";
import { campusShape } from "./campus_geometry";

export interface Campus {
  readonly view: Schemas["CampusView"];
  readonly shape: CampusShape;
}

export const campus = signal<Campus | null>(null);
export const campusProblem = signal<Problem | null>(null);

/** Fetches what the campus is and how it is drawn; again after a change of its map. */
export async function loadCampus(): Promise<void> {
  campusProblem.value = null;
  const [view, geometry] = await Promise.all([
    answerOf(api.GET("/api/v1/campus")),
    answerOf(api.GET("/api/v1/campus/map")),
  ]);
  if (!view.ok) campusProblem.value = view.problem;
  else if (!geometry.ok) campusProblem.value = geometry.problem;
  else campus.value = { view: view.value, shape: campusShape(geometry.value) };
}
