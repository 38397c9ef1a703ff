import type { Schemas } from "../../../shared/api/client";
import type { Scene, VehicleScene, VehicleStatus } from "../../../shared/scene/scene";

export type Track = Readonly<Schemas["Track"]>;
export type PastVehicle = Readonly<Schemas["PastVehicle"]>;
export type PastRide = Readonly<Schemas["PastRide"]>;

/** A shuttle that was last heard longer ago than this has no known place. Statuses are stored twice a second. */
const UNKNOWN_AFTER_MS = 15_000;
/** Across a longer silence, or a larger step, a shuttle is not drawn in between. */
const BETWEEN_MS = 6_000;
const BETWEEN_M = 60;

/** What stored positions tell of a status; what they do not tell is empty. */
const BLANK: VehicleStatus = {
  type: "status",
  epoch: 0,
  stamp_ns: 0,
  pose_map: [0, 0, 0],
  speed_mps: 0,
  accel_mps2: 0,
  steer_rad: 0,
  mode: "held",
  battery_ratio: -1,
  doors_open: false,
  lane_id: "",
  s_m: 0,
  order_id: "",
  revision: 0,
  visit_id: "",
  aboard: [],
  screen: "",
  spoken: "",
  obstacle_m: null,
  waiting_for: "",
  faults: [],
  hold_reason: null,
  hold_detail: "",
  localization: null,
  driving: null,
};

/** The number of the last entry at or before a time; -1 for none. */
export function lastAt(at_ms: readonly number[], moment_ms: number): number {
  let [low, high] = [0, at_ms.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (at_ms[middle]! <= moment_ms) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Where the fleet was, from the tracks of the piece of time in which the moment lies. */
export function sceneOfPast(
  moment_ms: number,
  vehicles: readonly PastVehicle[],
  tracks: readonly Track[],
  rides: readonly PastRide[],
  map_version: string,
): Scene {
  const by_id = new Map(tracks.map((track) => [track.vehicle_id, track]));
  const known = new Set(vehicles.map((vehicle) => vehicle.vehicle_id));
  const gone = tracks
    .filter((track) => !known.has(track.vehicle_id))
    .map(({ vehicle_id }) => ({ vehicle_id, name: vehicle_id, seats: 0 }));
  const aboard = new Map<string, number>();
  for (const ride of rides)
    if (isAboard(ride, moment_ms))
      aboard.set(ride.vehicle_id, (aboard.get(ride.vehicle_id) ?? 0) + ride.party);
  return {
    at_ms: moment_ms,
    campus_id: "",
    map_version,
    vehicles: [...vehicles, ...gone].map((vehicle) =>
      vehicleOfPast(moment_ms, vehicle, by_id.get(vehicle.vehicle_id), aboard),
    ),
    rides: [],
    incidents: { open: 0, unacknowledged: 0, help_calls: 0, serial: 0 },
    areas: [],
  };
}

export function isAboard(ride: PastRide, moment_ms: number): boolean {
  return (
    ride.boarded_ms > 0 &&
    ride.boarded_ms <= moment_ms &&
    (ride.ended_ms === 0 || moment_ms < ride.ended_ms)
  );
}

function vehicleOfPast(
  moment_ms: number,
  { vehicle_id, name, seats }: PastVehicle,
  track: Track | undefined,
  aboard: ReadonlyMap<string, number>,
): VehicleScene {
  const entry = track === undefined ? -1 : lastAt(track.at_ms, moment_ms);
  const is_known =
    track !== undefined && entry >= 0 && moment_ms - track.at_ms[entry]! < UNKNOWN_AFTER_MS;
  return {
    vehicle_id,
    facts: {
      name,
      seats,
      wheelchair_places: 0,
      connected: is_known,
      held: false,
      in_service: true,
      charging: false,
      mode: is_known ? track.mode[entry]! : "held",
    },
    task: {
      next_stop: "",
      people_aboard: aboard.get(vehicle_id) ?? 0,
      at_charger: false,
      route: [],
      visits: [],
      order_waits: false,
      hold_ends_ms: 0,
      charged_at_ms: 0,
      unavailable_since_ms: 0,
    },
    status: is_known ? statusAt(track, entry, moment_ms) : null,
    heard_ms: is_known ? track.at_ms[entry]! : 0,
    command: null,
  };
}

function statusAt(track: Track, entry: number, moment_ms: number): VehicleStatus {
  return {
    ...BLANK,
    pose_map: poseAt(track, entry, moment_ms),
    speed_mps: track.speed_mps[entry]!,
    mode: track.mode[entry]!,
    battery_ratio: track.battery_ratio[entry]!,
  };
}

/** On the straight line to the next position, which is a second of driving away. */
function poseAt(track: Track, entry: number, moment_ms: number): [number, number, number] {
  const [x_m, y_m, yaw_rad] = [track.x_m[entry]!, track.y_m[entry]!, track.yaw_rad[entry]!];
  if (entry + 1 >= track.at_ms.length) return [x_m, y_m, yaw_rad];
  const [dx_m, dy_m] = [track.x_m[entry + 1]! - x_m, track.y_m[entry + 1]! - y_m];
  const gap_ms = track.at_ms[entry + 1]! - track.at_ms[entry]!;
  if (gap_ms > BETWEEN_MS || Math.hypot(dx_m, dy_m) > BETWEEN_M) return [x_m, y_m, yaw_rad];
  const share = (moment_ms - track.at_ms[entry]!) / gap_ms;
  const turn_rad = track.yaw_rad[entry + 1]! - yaw_rad;
  const shortest_rad = Math.atan2(Math.sin(turn_rad), Math.cos(turn_rad));
  return [x_m + share * dx_m, y_m + share * dy_m, yaw_rad + share * shortest_rad];
}
