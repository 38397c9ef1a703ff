import type { CampusGeometry } from "../campus/campus_geometry";
import type { Point, Scene } from "../scene/scene";
import type { Camera } from "./camera/camera";
import type { Palette } from "./drawing/palette";

/** A page's own drawing on the map; the context is in map metres. */
export type MapLayer = (
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  geometry: CampusGeometry,
) => void;

/** What the map shows besides the campus itself. */
export interface MapContent {
  readonly scene: Scene | null;
  readonly pickup: string;
  readonly destination: string;
  readonly selected_vehicle: string;
  /** Closed roads, as lines in the map frame. */
  readonly closed_roads?: readonly (readonly Point[])[];
  readonly language: string;
  /** Shuttles move smoothly between two reports; otherwise they jump to the newest one. */
  readonly interpolate: boolean;
  /** Drawn over the routes. */
  readonly layer?: MapLayer;
  /** The camera follows the selected shuttle until the user moves it. */
  readonly follow?: boolean;
  /** A tap selects the ground, whatever stands there. */
  readonly selects_ground?: boolean;
}

export type MapSelection =
  | { readonly kind: "stop" | "vehicle"; readonly id: string }
  /** `reach_m`: how far a finger or a mouse may miss what is meant. */
  | { readonly kind: "ground"; readonly at: Point; readonly reach_m: number };

/** Dragging things of the map. All places are in map metres. */
export interface MapDrag {
  /** Whether something is taken hold of at this place. */
  grab(at: Point, reach_m: number): boolean;
  drag(at: Point): void;
  drop(): void;
  letGo(): void;
}

export interface MapEvents {
  selected(selection: MapSelection): void;
  /** What can be dragged now; null: nothing, and dragging moves the camera. */
  drag(): MapDrag | null;
  /** The user moved the camera: following and fitting end. */
  cameraMoved(): void;
}
