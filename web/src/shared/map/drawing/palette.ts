import type { Urgency } from "../../scene/condition";
import type { AreaState } from "../../scene/observation_areas";

/** The map's colours. They come from the page's custom properties, so that CSS alone decides on dark mode. */
export interface Palette {
  readonly ground: string;
  readonly building: string;
  readonly road: string;
  readonly road_edge: string;
  readonly route: string;
  readonly closed_road: string;
  readonly ink: string;
  readonly halo: string;
  readonly stop: string;
  readonly pickup: string;
  readonly destination: string;
  readonly vehicle: Record<Urgency, string>;
  readonly on_vehicle: string;
  readonly area: Record<AreaState, string>;
  readonly path: string;
  readonly people: string;
  readonly yielded_to: string;
  /** What a shuttle sees in detail; the console's own. */
  readonly seen: Record<"pedestrian" | "cyclist" | "vehicle" | "other" | "stop", string> & {
    /** Of lidar points, from the road upwards. */
    readonly points: readonly [string, string, string];
  };
  readonly font: string;
  /** The size of labels; it follows the size of text that the reader has set. */
  readonly text_px: number;
}

export function readPalette(element: Element): Palette {
  const style = getComputedStyle(element);
  const value = (name: string) => style.getPropertyValue(name).trim();
  return {
    ground: value("--map-ground"),
    building: value("--map-building"),
    road: value("--map-road"),
    road_edge: value("--map-road-edge"),
    route: value("--map-route"),
    closed_road: value("--danger"),
    ink: value("--ink"),
    halo: value("--map-halo"),
    stop: value("--map-stop"),
    pickup: value("--accent"),
    destination: value("--ink"),
    vehicle: {
      danger: value("--danger"),
      warning: value("--warning"),
      good: value("--accent"),
      calm: value("--ink-soft"),
    },
    on_vehicle: value("--surface"),
    area: {
      clear: value("--accent"),
      occupied: value("--danger"),
      unknown: value("--ink-soft"),
    },
    path: value("--map-path"),
    people: value("--map-people"),
    yielded_to: value("--danger"),
    seen: {
      pedestrian: value("--seen-pedestrian"),
      cyclist: value("--seen-cyclist"),
      vehicle: value("--seen-vehicle"),
      other: value("--seen-other"),
      points: [value("--seen-point-low"), value("--seen-point"), value("--seen-point-high")],
      stop: value("--danger"),
    },
    font: style.fontFamily,
    text_px: 0.75 * parseFloat(getComputedStyle(document.documentElement).fontSize),
  };
}
