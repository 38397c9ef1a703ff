import type { LocalizationPhase } from "../../shared/scene/scene";

/** How well a shuttle knows where it is, and the place that an operator names. */
export const positionEn = {
  localization: "Position",
  localization_phases: {
    waiting: "waits for satellites, or for a place that you name",
    tracking: "scans agree with the map",
    doubtful: "in doubt, drives slowly",
    lost: "lost, stands and searches",
    recovered: "found again",
    gnss_only: "by satellites alone",
  } as Readonly<Record<LocalizationPhase, string>>,
  position_deviation: (phase: string, deviation: string) => `${phase}, ± ${deviation}`,
  named_position: "Name its place",
  named_position_hint:
    "For a shuttle that stands and does not know where it is. It compares what its lidar sees with the map there, within 10 m.",
  name_position: "Choose on the map",
  click_place: "Click on the map where the shuttle stands.",
  click_direction: "Now click where its front points to.",
  position_chosen: (x_m: string, y_m: string) =>
    `Chosen: ${x_m} m east, ${y_m} m north. Another click begins again.`,
  confirm_position: "It stands here",
  position_sent: "Sent. Its answer comes within 20 seconds, beside its last command.",
};
