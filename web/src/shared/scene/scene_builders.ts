import type { OnboardScene } from "./onboard_scene";
import type { DrivingView, RideScene, Scene, VehicleScene, VehicleStatus } from "./scene";

type Facts = VehicleScene["facts"];
type Task = VehicleScene["task"];
export type VehicleChanges = Partial<Facts & Task & VehicleStatus & Omit<VehicleScene, "facts">>;

const FACTS: Facts = {
  name: "Shuttle 1",
  seats: 6,
  wheelchair_places: 1,
  connected: true,
  held: false,
  in_service: true,
  charging: false,
  mode: "autonomous",
};

const TASK: Task = {
  next_stop: "",
  people_aboard: 0,
  at_charger: false,
  route: [],
  visits: [],
  order_waits: false,
  hold_ends_ms: 0,
  charged_at_ms: 0,
  unavailable_since_ms: 0,
};

/** A shuttle that drives, for tests. Each change goes to every part that has a field of its name. */
export function aVehicle(changes: VehicleChanges = {}): VehicleScene {
  const vehicle = {
    vehicle_id: "shuttle-1",
    facts: changed(FACTS, changes),
    task: changed(TASK, changes),
    status: aStatus(changes),
    heard_ms: 0,
    command: null,
  };
  return changed<VehicleScene>(vehicle, changes);
}

function changed<Part extends object>(part: Part, changes: object): Part {
  const names = Object.keys(part).filter((name) => name in changes);
  const values = names.map((name) => [name, changes[name as keyof typeof changes]]);
  return { ...part, ...Object.fromEntries(values) };
}

export function aStatus(changes: object = {}): VehicleStatus {
  const status: VehicleStatus = {
    type: "status",
    epoch: 1,
    stamp_ns: 0,
    pose_map: [0, 0, 0],
    speed_mps: 3,
    accel_mps2: 0,
    steer_rad: 0,
    mode: "autonomous",
    battery_ratio: 0.8,
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
    driving: null,
    localization: null,
  };
  return changed(status, changes);
}

export function aDrivingView(changes: Partial<DrivingView> = {}): DrivingView {
  return {
    limited_by: null,
    path: [],
    tracks: [],
    areas: [],
    turn_signal: null,
    headlights: null,
    horn: null,
    guard: "",
    ...changes,
  };
}

export function aRide(changes: Partial<RideScene> = {}): RideScene {
  return {
    ride_id: "ride-1",
    ride_code: "K7MQ2X",
    state: "assigned",
    from_stop: "gate",
    to_stop: "library",
    party: 1,
    vehicle_id: "shuttle-1",
    pickup_from_ms: 0,
    pickup_to_ms: 0,
    arrive_by_ms: 0,
    pickup_eta_ms: 0,
    arrival_eta_ms: 0,
    arrival_earliest_ms: 0,
    arrival_latest_ms: 0,
    reason: "",
    pickup_earliest_ms: 0,
    pickup_latest_ms: 0,
    seats_left: null,
    ...changes,
  };
}

export function aScene(changes: Partial<Scene> = {}): Scene {
  return {
    at_ms: 0,
    campus_id: "campus",
    map_version: "m1",
    vehicles: [],
    rides: [],
    incidents: { open: 0, unacknowledged: 0, help_calls: 0, serial: 0 },
    areas: [],
    ...changes,
  };
}

/** A detailed scene in which the shuttle sees and plans nothing, with changes. */
export function anOnboardScene(changes: Partial<OnboardScene> = {}): OnboardScene {
  return {
    type: "onboard_scene",
    epoch: 0,
    stamp_ns: 0,
    points: [],
    points_age_s: 0,
    limited_by: null,
    speed_mps_planned: 0,
    guard: "",
    path_times: null,
    tick_times: null,
    tracks_by: "",
    tracks: [],
    tracks_age_s: 0,
    signs: [],
    scan: null,
    ...changes,
  };
}
