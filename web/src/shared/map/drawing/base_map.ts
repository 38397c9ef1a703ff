import type { CampusGeometry } from "../../campus/campus_geometry";
import type { Point } from "../../scene/scene";
import type { Camera, Size } from "../camera/camera";
import type { Palette } from "./palette";

interface RoadGroup {
  readonly width_m: number;
  readonly path: Path2D;
}

const ROAD_PX_MIN = 2.5;
const EDGE_PX = 1.5;
const BUILDINGS_FROM_PX_PER_M = 0.08;

/** Roads and buildings as paths in map metres, built once for each map. */
export class BaseMap {
  private readonly roads: readonly RoadGroup[];
  private readonly buildings = new Path2D();

  constructor(geometry: CampusGeometry) {
    const groups = new Map<number, Path2D>();
    for (const lane of geometry.lanes) {
      const path = groups.get(lane.width_m) ?? new Path2D();
      addPolyline(path, lane.points);
      groups.set(lane.width_m, path);
    }
    this.roads = [...groups].map(([width_m, path]) => ({ width_m, path }));
    for (const outline of geometry.buildings) {
      addPolyline(this.buildings, outline);
      this.buildings.closePath();
    }
  }

  /** The context must be in map metres (see setMapTransform). */
  draw(context: CanvasRenderingContext2D, camera: Camera, palette: Palette): void {
    if (camera.px_per_m > BUILDINGS_FROM_PX_PER_M) {
      context.fillStyle = palette.building;
      context.fill(this.buildings);
    }
    context.lineCap = "round";
    context.lineJoin = "round";
    for (const [colour, extra_px] of [
      [palette.road_edge, 2 * EDGE_PX],
      [palette.road, 0],
    ] as const) {
      context.strokeStyle = colour;
      for (const road of this.roads) {
        context.lineWidth =
          Math.max(road.width_m, ROAD_PX_MIN / camera.px_per_m) + extra_px / camera.px_per_m;
        context.stroke(road.path);
      }
    }
  }
}

/** Makes the context draw in map metres, y north, until the caller restores it. */
export function setMapTransform(
  context: CanvasRenderingContext2D,
  camera: Camera,
  size: Size,
  pixel_ratio: number,
): void {
  const scale = camera.px_per_m * pixel_ratio;
  context.setTransform(
    scale,
    0,
    0,
    -scale,
    (size.width_px / 2) * pixel_ratio - camera.x_m * scale,
    (size.height_px / 2) * pixel_ratio + camera.y_m * scale,
  );
}

/** A line of constant width on the screen; the context must be in map metres. */
export function drawLine(
  context: CanvasRenderingContext2D,
  camera: Camera,
  points: readonly Point[],
  colour: string,
  width_px: number,
): void {
  if (points.length < 2) return;
  const path = new Path2D();
  addPolyline(path, points);
  context.strokeStyle = colour;
  context.lineWidth = width_px / camera.px_per_m;
  context.lineCap = "round";
  context.lineJoin = "round";
  context.stroke(path);
}

function addPolyline(path: Path2D, points: readonly Point[]): void {
  points.forEach(([x, y], index) => (index === 0 ? path.moveTo(x, y) : path.lineTo(x, y)));
}
