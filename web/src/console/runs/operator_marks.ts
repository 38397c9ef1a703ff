import type { Schemas } from "../../shared/api/client";
import type { Mark } from "./marks";

type RunMark = Schemas["RunMark"];

/** What operators marked in a run, as marks of the timeline. */
export function marksOfOperators(vehicle_id: string, marks: readonly RunMark[]): readonly Mark[] {
  return marks.map(({ at_ms, kind, note, by, state, in_file }) => ({
    at_ms,
    kind: kind === "mark" ? "note" : "recording",
    vehicle_id,
    stop_id: "",
    ride_id: "",
    // What the record calls it, and what became of it while no file has it.
    detail: `vehicle.${kind}${in_file ? "" : ` ${state}`}`,
    by,
    text: note,
  }));
}

/** Marks of several sources, in order of time. */
export function inOrderOfTime(...sources: readonly (readonly Mark[])[]): readonly Mark[] {
  return sources.flat().sort((one, other) => one.at_ms - other.at_ms);
}
