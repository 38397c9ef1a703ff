import type { Scene, SpeedLimitReason, VehicleStatus } from "../shared/scene/scene";

/** What the vehicle's screen process sends; its messages are `ScreenScene` of the vehicle agent. */
export interface ScreenScene {
  readonly vehicle_id: string;
  readonly seats: number;
  readonly view: CabinView | null;
  readonly view_age_s: number | null;
  readonly announcements: readonly Announcement[];
  readonly answers: readonly Answer[];
  readonly help_age_s: number | null;
}

export interface CabinView {
  readonly status: VehicleStatus;
  readonly has_position: boolean;
  readonly connected: boolean | null;
  readonly utc_ns: number;
  readonly visits: readonly CabinVisit[];
  readonly aboard: number;
  readonly parties: number;
  readonly early_stop: boolean;
  readonly serving: boolean;
  readonly limited_by: SpeedLimitReason;
  /** The operators' announcement that stands now. */
  readonly shown: { readonly text: string; readonly text_zh: string } | null;
}

export interface CabinVisit {
  readonly visit_id: string;
  readonly kind: "stop" | "rest" | "temporary";
  readonly stop_id: string;
  readonly name: string;
  readonly name_en: string;
  readonly distance_m: number | null;
  readonly least_s: number | null;
  readonly boarding: number;
  readonly alighting: number;
}

export interface Announcement {
  readonly number: number;
  readonly text: string;
  readonly text_zh: string;
  readonly age_s: number;
}

export interface Answer {
  readonly number: number;
  readonly body: {
    readonly event:
      | "code_refused"
      | "destination_requested"
      | "help_requested"
      | "rider_alighted"
      | "rider_boarded"
      | "seat_button_pressed";
    readonly accepted?: boolean;
  };
  readonly age_s: number;
}

export type ScreenRequest =
  | { readonly type: "stop"; readonly seat: number }
  | { readonly type: "help" }
  | { readonly type: "code"; readonly code: string }
  | { readonly type: "destination"; readonly stop_id: string; readonly code: string };

/** A view that is older than this says nothing about now: the tick sends five a second. */
export const STALE_S = 2;

/** The newest view, or null if the vehicle has sent none for so long that its state is not known. */
export function currentView(scene: ScreenScene | null, silent_s: number): CabinView | null {
  if (scene === null || scene.view_age_s === null) return null;
  return scene.view_age_s + silent_s > STALE_S ? null : scene.view;
}

/** The view as a scene of one shuttle, for the map; null where the shuttle does not know its position. */
export function mapScene(vehicle_id: string, view: CabinView | null): Scene | null {
  if (view === null || !view.has_position) return null;
  return {
    at_ms: view.utc_ns / 1e6,
    campus_id: "",
    map_version: "",
    vehicles: [
      {
        vehicle_id,
        facts: {
          name: vehicle_id,
          seats: 0,
          wheelchair_places: 0,
          connected: true,
          held: false,
          in_service: true,
          charging: false,
          mode: view.status.mode,
        },
        task: {
          next_stop: view.visits[0]?.stop_id ?? "",
          people_aboard: view.aboard,
          at_charger: false,
          route: [],
          visits: [],
          order_waits: false,
          hold_ends_ms: 0,
          charged_at_ms: 0,
          unavailable_since_ms: 0,
        },
        status: view.status,
        heard_ms: view.utc_ns / 1e6,
        command: null,
      },
    ],
    rides: [],
    incidents: { open: 0, unacknowledged: 0, help_calls: 0, serial: 0 },
    areas: [],
  };
}

/** Whole minutes until a stop, at least 1; null if they are not known or the shuttle does not drive. */
export function minutesTo(visit: CabinVisit, view: CabinView): number | null {
  if (view.status.mode !== "autonomous" || view.status.waiting_for !== "") return null;
  return visit.least_s === null ? null : Math.max(1, Math.ceil(visit.least_s / 60));
}

export type DrivingState =
  | "unknown"
  | "doors"
  | "manual"
  | "safety_stop"
  | "held"
  | "early_stop"
  | "waiting"
  | "driving"
  | "standing";

const MOVING_MPS = 0.15;

/** The one state of the shuttle that decides its headline. */
export function drivingState(view: CabinView | null): DrivingState {
  if (view === null) return "unknown";
  const { status } = view;
  if (status.mode === "manual") return "manual";
  if (status.mode === "minimal_risk" || status.mode === "fault") return "safety_stop";
  if (status.doors_open) return "doors";
  if (status.mode === "held") return "held";
  if (view.early_stop) return "early_stop";
  if (Math.abs(status.speed_mps) >= MOVING_MPS) return "driving";
  return status.waiting_for !== "" ? "waiting" : "standing";
}

/** People that the shuttle tracks, and how many of them it slows down for; null if it does not know. */
export function peopleSeen(view: CabinView): { seen: number; yielded_to: number } | null {
  const tracks = view.status.driving?.tracks;
  if (!tracks) return null;
  const people = tracks.filter(([, kind]) => kind === "pedestrian" || kind === "cyclist");
  return { seen: people.length, yielded_to: people.filter((track) => track[7] === true).length };
}
