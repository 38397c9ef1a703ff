import type { Schemas } from "../../shared/api/client";
import { pointsOf } from "../../shared/campus/campus_geometry";
import type { Point } from "../../shared/scene/scene";

/** What is closed now, as lines on the map. */
export function closedLines(closures: readonly Schemas["ClosureView"][]): readonly Point[][] {
  return closures
    .filter((closure) => closure.state === "in_force")
    .flatMap((closure) => closure.lines.map(pointsOf));
}
