import type { MapDrag } from "../../shared/map/map_content";
import type { Point } from "../../shared/scene/scene";
import type { Elements } from "./drawing";
import type { Chosen, EditorState } from "./editor_state";
import { kerbPulled, pulled, stopMoved } from "./edits";
import { elementAt } from "./hit";

/** Drags stops, and places of lanes and kerbs. What is dragged is only shown; putting it down is the step that is saved. */
export class ElementDrag implements MapDrag {
  private held: { readonly chosen: Chosen; readonly from: Point } | null = null;

  constructor(private readonly state: EditorState) {}

  grab(at: Point, reach_m: number): boolean {
    if (this.state.conflict.peek()) return false;
    const chosen = elementAt(this.state.elements.peek(), at, reach_m);
    if (chosen === null || moved(this.state.elements.peek(), chosen, at, at) === null) return false;
    this.held = { chosen, from: at };
    return true;
  }

  drag(at: Point): void {
    if (this.held === null) return;
    const { chosen, from } = this.held;
    this.state.chosen.value = chosen;
    this.state.preview.value = moved(this.state.elements.peek(), chosen, from, at);
  }

  drop(): void {
    const next = this.state.preview.peek();
    this.letGo();
    if (next !== null) this.state.draw(next);
  }

  letGo(): void {
    this.held = null;
    this.state.preview.value = null;
  }
}

/** The drawing with the element moved; null for one that is drawn anew instead. */
function moved(elements: Elements, chosen: Chosen, from: Point, to: Point): Elements | null {
  switch (chosen.kind) {
    case "stops":
      return stopMoved(elements, chosen.id, to);
    case "lanes":
      return pulled(elements, chosen.id, from, to);
    case "kerbs":
      return kerbPulled(elements, chosen.id, from, to);
    default:
      return null;
  }
}
