import type { components } from "../api/schema";

type Schemas = components["schemas"];

/**
 * What a screen shows of the campus at one time, live or replayed: the server's own schema. Times are
 * milliseconds since the Unix epoch, positions metres in the map frame (x east, y north), yaw
 * counter-clockwise from east.
 */
export type Scene = Readonly<Schemas["Scene"]>;
export type VehicleScene = Readonly<Schemas["VehicleScene"]>;
export type RideScene = Readonly<Schemas["RideScene"]>;
export type IncidentsScene = Readonly<Schemas["IncidentsScene"]>;
export type AreaScene = Readonly<Schemas["AreaScene"]>;
export type VehicleStatus = Readonly<Schemas["Status"]>;
export type DrivingView = Readonly<Schemas["DrivingView"]>;
export type DriveMode = VehicleStatus["mode"];
export type SpeedLimitReason = NonNullable<DrivingView["limited_by"]>;
export type TurnSignal = NonNullable<DrivingView["turn_signal"]>;
export type Headlights = NonNullable<DrivingView["headlights"]>;
export type HoldReason = NonNullable<VehicleStatus["hold_reason"]>;
export type LocalizationPhase = NonNullable<VehicleStatus["localization"]>["phase"];
export type VisitScene = Readonly<Schemas["VisitScene"]>;
export type IncidentKind = Schemas["IncidentKind"];
export type FaultCode = Schemas["FaultReport"]["code"];
export type CommandKind = Schemas["CommandScene"]["kind"];
export type CommandState = Schemas["CommandScene"]["state"];
export type SceneMessage = Schemas["Snapshot"] | Schemas["Delta"];
export type RideState = Schemas["RideState"];

export type Point = readonly [x_m: number, y_m: number];

export type EndState = Extract<
  RideState,
  "completed" | "refused" | "cancelled" | "no_show" | "failed"
>;

const END_STATES: ReadonlySet<string> = new Set<EndState>([
  "completed",
  "refused",
  "cancelled",
  "no_show",
  "failed",
]);

export function hasEnded(state: string): state is EndState {
  return END_STATES.has(state);
}

/** Whether the shuttle stands at the stop with open doors; only then does it accept a tap. */
export function hasDoorsOpenAt(vehicle: VehicleScene, stop_id: string): boolean {
  return vehicle.status?.doors_open === true && vehicle.task.next_stop === stop_id;
}

export interface Pose {
  readonly x_m: number;
  readonly y_m: number;
  readonly yaw_rad: number;
}

/** Where the shuttle is by its newest status; null before its first. */
export function poseOf(vehicle: VehicleScene): Pose | null {
  if (vehicle.status === null) return null;
  const [x_m, y_m, yaw_rad] = vehicle.status.pose_map;
  return { x_m, y_m, yaw_rad };
}

/** The mode of the newest status, or what the store knows. */
export function modeOf(vehicle: VehicleScene): DriveMode {
  return vehicle.status?.mode ?? vehicle.facts.mode;
}
