import type { ConsoleTexts } from "../texts/texts_en";

export interface LidarFault {
  readonly code: keyof ConsoleTexts["lidar_causes"];
  /** The lidar's name in the shuttle's own sensors.toml, or several. */
  readonly lidar: string;
}

const CODES: readonly LidarFault["code"][] = [
  "lidar_blind",
  "lidar_silent",
  "lidar_unusable",
  "lidar_moved",
];

/** What an incident's cause says of a lidar by name; null for any other cause. */
export function lidarFault(cause: string): LidarFault | null {
  const found = /^(\w+) \((.+)\)$/s.exec(cause);
  const code = CODES.find((known) => known === found?.[1]);
  return found === null || code === undefined ? null : { code, lidar: found[2]! };
}
