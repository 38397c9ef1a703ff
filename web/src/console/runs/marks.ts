import type { Schemas } from "../../shared/api/client";
import type { Scene, VehicleStatus } from "../../shared/scene/scene";

export type Mark = Readonly<Schemas["Mark"]>;
export type MarkKind = Mark["kind"];

/** Rows of the timeline: what was wrong, what people ordered, where shuttles stopped. */
export const MARK_ROWS: readonly (readonly MarkKind[])[] = [
  ["takeover", "minimal_risk_stop", "braking", "blocked", "fault", "incident"],
  ["intervention", "seat_button", "note", "recording"],
  ["stop"],
];

/** Harder braking than any plan asks for. */
const HARD_BRAKING_MPS2 = -2;
/** The guard brakes for a contact ahead, as hard as it takes. */
const CONTACT = "obstacle";
/** A braking that begins again within this time is the same one. */
const SAME_BRAKING_MS = 2_000;
/** Neighbouring marks closer than this share of the timeline are drawn as one. */
export const BUCKETS = 400;

/** What happened in a run, as its own reports tell it, oldest first. */
export function marksOfScenes(scenes: readonly Scene[]): readonly Mark[] {
  const marks: Mark[] = [];
  let before: Scene["vehicles"][number]["status"] = null;
  let braked_ms = Number.NEGATIVE_INFINITY;
  for (const { at_ms, vehicles } of scenes) {
    const [vehicle] = vehicles;
    const status = vehicle?.status ?? null;
    if (vehicle === undefined || status === null) continue;
    const add = (kind: MarkKind, rest: Partial<Mark> = {}) =>
      marks.push({
        at_ms,
        kind,
        vehicle_id: vehicle.vehicle_id,
        stop_id: "",
        ride_id: "",
        detail: "",
        by: "",
        text: "",
        ...rest,
      });
    if (status.doors_open && before?.doors_open !== true)
      add("stop", { stop_id: vehicle.task.next_stop });
    if (status.mode !== before?.mode && before !== null) {
      if (status.mode === "manual") add("takeover", { detail: status.hold_reason ?? "" });
      if (status.mode === "minimal_risk")
        add("minimal_risk_stop", { detail: status.hold_reason ?? "" });
    }
    if (status.accel_mps2 <= HARD_BRAKING_MPS2 || status.driving?.guard === CONTACT) {
      if (at_ms - braked_ms > SAME_BRAKING_MS)
        add("braking", { detail: `braking_by_${brakes(status)}` });
      braked_ms = at_ms;
    }
    for (const { code } of status.faults)
      if (!before?.faults.some((fault) => fault.code === code)) add("fault", { detail: code });
    before = status;
  }
  return marks;
}

/** Acts of the guard in which it does what the planner has asked for. */
const NOT_OF_GUARD: ReadonlySet<string> = new Set(["", "emergency"]);

/** Who brakes hard: the gate has a fault for it, a driver has the vehicle, else the guard or the plan. */
function brakes(status: VehicleStatus): "gate" | "driver" | "guard" | "planner" {
  if (status.faults.some(({ code }) => code.startsWith("gate_braking_"))) return "gate";
  if (status.mode === "manual") return "driver";
  return NOT_OF_GUARD.has(status.driving?.guard ?? "") ? "planner" : "guard";
}

/** The first mark after a time, or the last one before it. */
export function nextMark(
  marks: readonly Mark[],
  at_ms: number,
  direction: 1 | -1,
): Mark | undefined {
  return direction === 1
    ? marks.find((mark) => mark.at_ms > at_ms)
    : marks.findLast((mark) => mark.at_ms < at_ms);
}

/** For each row the places of its marks, as whole parts of the timeline from 0 to `BUCKETS`. */
export function markedBuckets(
  marks: readonly Mark[],
  start_ms: number,
  end_ms: number,
): readonly (readonly number[])[] {
  const length_ms = Math.max(end_ms - start_ms, 1);
  return MARK_ROWS.map((kinds) => {
    const places = new Set<number>();
    for (const { at_ms, kind } of marks)
      if (kinds.includes(kind) && at_ms >= start_ms && at_ms <= end_ms)
        places.add(Math.floor((BUCKETS * (at_ms - start_ms)) / length_ms));
    return [...places];
  });
}
