import { modeOf, type VehicleScene } from "./scene";

/** The one state of a shuttle that decides its colour, its badge and its text. */
export type Condition =
  | "offline"
  | "fault"
  | "minimal_risk"
  | "manual"
  | "held"
  | "boarding"
  | "blocked"
  | "waiting"
  | "driving"
  | "charging"
  | "standing";

/** How much attention a condition asks for. Its colour never stands alone: a badge or a text says the same. */
export type Urgency = "danger" | "warning" | "good" | "calm";

const MOVING_MPS = 0.15;
/** A shuttle stops about a metre ahead of an obstacle; an obstacle further away than this does not block it. */
const BLOCKED_WITHIN_M = 6;
/** A battery above this hardly charges any more. */
const FULL_RATIO = 0.99;

export function conditionOf(vehicle: VehicleScene): Condition {
  const { facts, status, task } = vehicle;
  if (!facts.connected) return "offline";
  const mode = modeOf(vehicle);
  if (mode === "fault") return "fault";
  if (mode === "minimal_risk") return "minimal_risk";
  if (mode === "manual") return "manual";
  if (facts.held || mode === "held") return "held";
  if (status === null) return "standing";
  if (status.doors_open) return "boarding";
  if (Math.abs(status.speed_mps) >= MOVING_MPS) return "driving";
  if (status.waiting_for !== "") return "waiting";
  if (status.obstacle_m !== null && status.obstacle_m <= BLOCKED_WITHIN_M) return "blocked";
  if (task.at_charger && status.battery_ratio < FULL_RATIO) return "charging";
  return "standing";
}

const URGENCY: Record<Condition, Urgency> = {
  offline: "danger",
  fault: "danger",
  minimal_risk: "danger",
  manual: "warning",
  held: "warning",
  blocked: "warning",
  waiting: "calm",
  boarding: "good",
  driving: "good",
  charging: "calm",
  standing: "calm",
};

export function urgencyOf(condition: Condition): Urgency {
  return URGENCY[condition];
}
