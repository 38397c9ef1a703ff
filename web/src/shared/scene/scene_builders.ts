import type { PictureScene, RideScene, Scene, VehicleScene } from "./scene";

/** A shuttle that drives, for tests. */
export function aVehicle(changes: Partial<VehicleScene> = {}): VehicleScene {
  return {
    vehicle_id: "shuttle-1",
    name: "Shuttle 1",
    seats: 6,
    x_m: 0,
    y_m: 0,
    yaw_rad: 0,
    speed_mps: 3,
    located: true,
    mode: "autonomous",
    connected: true,
    held: false,
    in_service: true,
    heard_ms: 0,
    battery_ratio: 0.8,
    charging: false,
    doors_open: false,
    obstacle_m: null,
    waiting_for: "",
    screen: "",
    spoken: "",
    order_id: "",
    visit_id: "",
    next_stop: "",
    aboard: [],
    people_aboard: 0,
    faults: [],
    route: [],
    driving: null,
    ...changes,
  };
}

export function aDrivingView(changes: Partial<PictureScene> = {}): PictureScene {
  return { limited_by: "", path: [], tracks: [], areas: [], ...changes };
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
    reason: "",
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
