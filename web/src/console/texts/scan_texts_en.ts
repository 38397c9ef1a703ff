import type { Schemas } from "../../shared/api/client";

type RequestState = Schemas["ScanRequestView"]["state"];
type VehicleState = Schemas["ScanVehicle"]["state"];
type ProposalState = Schemas["ProposalView"]["state"];

/** Scans of an area, and the point maps that are made of them. */
export const scanEn = {
  scans: "Scans for a new map",
  scans_lead:
    "Shuttles keep lidar scans while they drive in the area, and send them. Ask for an area that has changed.",
  scan_name: "What the scans are for",
  scan_area: "Area",
  scan_area_choice: { campus: "Whole campus", drawn: "An area on the map" },
  scan_area_map: "Map of the area",
  scan_area_hint: "Click the corners of the area, one after another. At least three are needed.",
  scan_corners: (count: number) => (count === 1 ? "1 corner" : `${count} corners`),
  scan_last_corner: "Remove the last corner",
  scan_hours: "Hours until the request ends",
  scan_gigabytes: "GB after which it ends",
  scan_ask: "Ask for scans",
  no_scan_requests: "No scans were asked for yet.",
  scan_request_states: {
    open: "Open",
    operator: "Ended by an operator",
    time: "Ended: its time is over",
    size: "Ended: enough has come",
  } satisfies Readonly<Record<RequestState, string>>,
  scan_request_asked: (by: string, when: string) => `Asked for by ${by}, ${when}`,
  scan_received: (scans: number, metres: string, megabytes: string) =>
    `${scans} scans on ${metres} m have come, ${megabytes} MB`,
  scan_vehicle: (vehicle: string, state: string, scans: number, metres: string) =>
    `${vehicle}: ${state}. ${scans} scans on ${metres} m have come`,
  scan_vehicle_states: {
    waiting: "not in the area",
    collecting: "keeps scans",
    ended: "done",
    disk_full: "no room on its disk",
    no_scans: "its lidar is silent",
    not_uploaded: "cannot send its scans, tries again",
    keeper_silent: "the process that keeps scans does not answer",
    old_agent: "its software is too old for this",
    unknown: "has not said anything yet",
  } satisfies Readonly<Record<VehicleState, string>>,
  scan_end: "End",
  scan_make_map: "Make a map",
  map_proposals: "Proposed maps",
  map_proposals_lead:
    "A proposed map is not in force. Look at what has changed, then publish or dismiss it.",
  no_map_proposals: "No map was proposed yet.",
  proposal_states: {
    queued: "Waits for the map before it",
    building: "Is being made",
    stopped: "Stopped",
    failed: "Failed",
    ready: "Ready for a decision",
    published: "Published",
    dismissed: "Dismissed",
  } satisfies Readonly<Record<ProposalState, string>>,
  proposal_progress: (stage: string, percent: number) => `${stage}: ${percent} %`,
  proposal_stages: {
    "": "start",
    odometry: "following the drives",
    ground: "finding the ground",
    "loops by looks": "finding places again",
    "loops within 15 m": "joining passes, roughly",
    "loops within 8 m": "joining passes, finely",
    surfaces: "making surfaces",
    comparison: "comparing",
  } as Readonly<Record<string, string>>,
  proposal_stop: "Stop",
  proposal_changed: (percent: string, changed: number, compared: number) =>
    `${percent} % of the surface has changed; ${changed} of ${compared} tiles differ`,
  proposal_nothing_in_force: "Nothing can be compared: no map is in force, or not in this place.",
  proposal_residual: (median: string, p95: string) =>
    `Where both have a surface they differ by ${median} cm, 95 % by less than ${p95} cm`,
  proposal_shift: (metres: string) => `Moved by ${metres} m to lie on the map in force`,
  proposal_made_of: (drives: number, scans: number, metres: string) =>
    `Made of ${drives} drives, ${scans} scans on ${metres} m`,
  proposal_moving: (count: number) => `${count} surfaces of moving things were removed`,
  proposal_picture: (name: string) => `${name}: both maps from above, changes in colours`,
  proposal_tile: "Tile",
  proposal_columns: {
    changed: "Changed",
    new: "New",
    moved: "Moved",
    gone: "Gone",
    same: "Same",
    unseen: "Not seen",
  },
  proposal_tile_added: "added",
  proposal_file: "Map as a file",
  proposal_publish: "Publish",
  proposal_publish_text:
    "The map is put in force. Shuttles fetch it and change over when they stand. You can put the former map back in force.",
  proposal_dismiss: "Dismiss",
  proposal_dismiss_text: "The map in force stays. The scans and the proposal are kept.",
  proposal_note: "Note",
  proposal_decided: (state: string, by: string, when: string) => `${state} by ${by}, ${when}`,
};
