import type { Signal } from "@preact/signals";
import type { Point } from "../../shared/scene/scene";
import type { EditorState } from "./editor_state";
import {
  drawnLane,
  pulled,
  split,
  stopMoved,
  withCrossing,
  withKerb,
  withStop,
  withStopLine,
  withZone,
} from "./edits";
import { elementAt } from "./hit";

export const TOOLS = [
  "select",
  "move",
  "lane",
  "split",
  "stop",
  "crossing",
  "stop_line",
  "zone",
  "kerb",
] as const;
export type Tool = (typeof TOOLS)[number];

/** Tools that take several places, until the line is finished. */
export const DRAWS_LINE: readonly Tool[] = ["lane", "kerb"];

/** What a tap at a place does with a tool. Places of an unfinished step are in `clicked`. */
export function tapped(
  state: EditorState,
  tool: Tool,
  clicked: Signal<readonly Point[]>,
  at: Point,
  reach_m: number,
  new_stop: string,
): void {
  const elements = state.elements.peek();
  const chosen = state.chosen.peek();
  switch (tool) {
    case "select":
      state.chosen.value = elementAt(elements, at, reach_m);
      return;
    case "move":
      if (chosen?.kind === "stops") {
        state.draw(stopMoved(elements, chosen.id, at));
        return;
      }
      if (chosen?.kind !== "lanes") {
        state.chosen.value = elementAt(elements, at, reach_m);
        return;
      }
      // The first tap takes hold of the lane, the second one pulls it there.
      if (clicked.value.length === 0) clicked.value = [at];
      else {
        state.draw(pulled(elements, chosen.id, clicked.value[0]!, at));
        clicked.value = [];
      }
      return;
    case "split":
      if (chosen?.kind === "lanes") state.draw(split(elements, chosen.id, at));
      else state.chosen.value = elementAt(elements, at, reach_m);
      return;
    case "stop":
      state.draw(withStop(elements, at, new_stop));
      state.chosen.value = elementAt(state.elements.peek(), at, Math.max(reach_m, 10));
      return;
    case "crossing":
      state.draw(withCrossing(elements, at));
      return;
    case "stop_line":
      if (chosen?.kind === "observation_areas") state.draw(withStopLine(elements, chosen.id, at));
      else state.chosen.value = elementAt(elements, at, reach_m);
      return;
    case "zone":
      if (clicked.value.length === 0) clicked.value = [at];
      else {
        state.draw(withZone(elements, clicked.value[0]!, at));
        clicked.value = [];
      }
      return;
    case "lane":
    case "kerb":
      clicked.value = [...clicked.value, at];
  }
}

/** Ends the line that is being drawn. */
export function finishLine(
  state: EditorState,
  tool: Tool,
  clicked: Signal<readonly Point[]>,
): void {
  const places = clicked.value;
  clicked.value = [];
  if (places.length < 2) return;
  if (tool === "kerb") {
    state.draw(withKerb(state.elements.peek(), places));
    return;
  }
  const drawn = drawnLane(state.elements.peek(), places);
  state.draw(drawn.elements);
  state.chosen.value = { kind: "lanes", id: drawn.lane_id };
}
