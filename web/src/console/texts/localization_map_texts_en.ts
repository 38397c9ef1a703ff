import type { Schemas } from "../../shared/api/client";

type MapKind = Schemas["LocalizationMapView"]["kind"];

/** What shuttles compare their scans with. */
export const localizationMapEn = {
  localization_maps: "Localization maps",
  localization_maps_lead:
    "Shuttles compare their scans with such a map. They fetch the one in force and change over when they stand.",
  no_localization_maps: "No localization map is stored. Send one with campusloop map upload.",
  localization_map_kinds: {
    points: "Surfaces, for lidars",
    occupancy: "Occupied cells, for planar scanners",
  } satisfies Readonly<Record<MapKind, string>>,
  localization_map_size: (tiles: number, megabytes: string) => `${tiles} tiles, ${megabytes} MB`,
  localization_map_published: (by: string, when: string, version: string) =>
    `Published by ${by}, ${when} · ${version}`,
  localization_map_activated: (by: string, when: string) => `Put in force by ${by}, ${when}`,
  localization_map_elsewhere:
    "It lies in another frame than the road map in force. No shuttle fetches it.",
  localization_map_used_by: (vehicles: string) => `In use on: ${vehicles}`,
  localization_map_awaited: (vehicle: string, change: string) => `${vehicle}: ${change}`,
  localization_map_changes: {
    "": "has not fetched it yet",
    stored: "has it, and changes over when it stands",
    not_downloaded: "cannot download it, tries again",
    damaged: "got damaged tiles, tries again",
    unsound: "cannot use it",
    elsewhere: "drives by a road map of another frame",
    not_stored: "has no room for it on its disk",
  } as Readonly<Record<string, string>>,
  put_localization_map_text:
    "Shuttles that compare scans with a map of this kind fetch it by themselves. Each changes over when it stands, and keeps the former one for a roll back.",
  remove_localization_map: "Remove",
  remove_localization_map_text:
    "The server deletes this version, and the tiles that no other version has. You cannot roll back to it.",
};
