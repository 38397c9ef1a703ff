import type { Condition } from "../scene/condition";
import { conditionOf } from "../scene/condition";
import type { VehicleScene } from "../scene/scene";
import type { Knowledge } from "./knowledge";
import { isOld, OLD_MS } from "./knowledge";

export type StopCause = "held" | "manual" | "fault";

/** What makes a stopped shuttle go on: the server at a known time, the operators, or who drives it by hand. */
type Next =
  | { readonly next: "resumes_at"; readonly resumes_ms: number }
  | { readonly next: "operators_release" | "operators_check" | "person_drives" };

/** A shuttle that stands for a reason which no plan knows of. since_ms: null where it is not known. */
export type Stopped = Next & {
  readonly kind: "stopped";
  readonly cause: StopCause;
  readonly since_ms: number | null;
};

/** Nothing has been heard since then: whatever was true may be over. */
export interface Unknown {
  readonly kind: "unknown";
  readonly since_ms: number;
}

/** The one state of a shuttle for phone, console and replay. */
export type VehicleState =
  | { readonly kind: "driving" }
  | { readonly kind: "at_stop"; readonly stop_id: string }
  | { readonly kind: "standing" }
  | Stopped
  | Unknown;

const CAUSES: Partial<Record<Condition, StopCause>> = {
  held: "held",
  manual: "manual",
  fault: "fault",
  minimal_risk: "fault",
};

export function vehicleState(vehicle: VehicleScene, knowledge: Knowledge): VehicleState {
  const { task, heard_ms } = vehicle;
  if (isOld(knowledge)) return { kind: "unknown", since_ms: knowledge.known_ms };
  const condition = conditionOf(vehicle);
  const is_silent = heard_ms > 0 && knowledge.now_ms - heard_ms > OLD_MS;
  if (condition === "offline" || is_silent)
    return { kind: "unknown", since_ms: heard_ms || task.unavailable_since_ms };
  const cause = CAUSES[condition];
  if (cause !== undefined) return stoppedState(vehicle, cause);
  if (condition === "boarding") return { kind: "at_stop", stop_id: task.next_stop };
  return { kind: condition === "driving" ? "driving" : "standing" };
}

function stoppedState({ task }: VehicleScene, cause: StopCause): Stopped {
  const since_ms = task.unavailable_since_ms || null;
  if (cause === "held" && task.hold_ends_ms > 0)
    return { kind: "stopped", cause, since_ms, next: "resumes_at", resumes_ms: task.hold_ends_ms };
  const next =
    cause === "held"
      ? "operators_release"
      : cause === "manual"
        ? "person_drives"
        : "operators_check";
  return { kind: "stopped", cause, since_ms, next };
}
