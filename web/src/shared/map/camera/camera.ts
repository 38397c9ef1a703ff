import type { Point } from "../../scene/scene";

/** The map point at the centre of the screen, and the number of pixels per metre. */
export interface Camera {
  readonly x_m: number;
  readonly y_m: number;
  readonly px_per_m: number;
}

export interface Size {
  readonly width_px: number;
  readonly height_px: number;
}

export interface Bounds {
  readonly x_min_m: number;
  readonly y_min_m: number;
  readonly x_max_m: number;
  readonly y_max_m: number;
}

/** Space at the edges that stays free or that something covers, in pixels. */
export interface Padding {
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
  readonly left: number;
}

const PX_PER_M_MIN = 0.02;
const PX_PER_M_MAX = 24;
/** Fitting two points that nearly coincide does not zoom in further than this. */
const FIT_PX_PER_M_MAX = 5;

/** Screen pixels (y down) of a map point. */
export function toScreen(camera: Camera, size: Size, x_m: number, y_m: number): Point {
  return [
    size.width_px / 2 + (x_m - camera.x_m) * camera.px_per_m,
    size.height_px / 2 - (y_m - camera.y_m) * camera.px_per_m,
  ];
}

/** The map point under a screen pixel: the inverse of toScreen. */
export function toMap(camera: Camera, size: Size, x_px: number, y_px: number): Point {
  return [
    camera.x_m + (x_px - size.width_px / 2) / camera.px_per_m,
    camera.y_m - (y_px - size.height_px / 2) / camera.px_per_m,
  ];
}

export function panCamera(camera: Camera, dx_px: number, dy_px: number): Camera {
  return {
    ...camera,
    x_m: camera.x_m - dx_px / camera.px_per_m,
    y_m: camera.y_m + dy_px / camera.px_per_m,
  };
}

/** The camera zoomed by a factor; the map point under (x_px, y_px) keeps its place on the screen. */
export function zoomCamera(
  camera: Camera,
  size: Size,
  x_px: number,
  y_px: number,
  factor: number,
): Camera {
  const px_per_m = Math.min(Math.max(camera.px_per_m * factor, PX_PER_M_MIN), PX_PER_M_MAX);
  const [x_m, y_m] = toMap(camera, size, x_px, y_px);
  return {
    x_m: x_m - (x_px - size.width_px / 2) / px_per_m,
    y_m: y_m + (y_px - size.height_px / 2) / px_per_m,
    px_per_m,
  };
}

export function boundsOf(points: Iterable<Point>): Bounds | null {
  let bounds: Bounds | null = null;
  for (const [x, y] of points) {
    bounds =
      bounds === null
        ? { x_min_m: x, y_min_m: y, x_max_m: x, y_max_m: y }
        : {
            x_min_m: Math.min(bounds.x_min_m, x),
            y_min_m: Math.min(bounds.y_min_m, y),
            x_max_m: Math.max(bounds.x_max_m, x),
            y_max_m: Math.max(bounds.y_max_m, y),
          };
  }
  return bounds;
}

/** The closest camera that shows all of the bounds inside the padding. */
export function fitCamera(bounds: Bounds, size: Size, padding: Padding): Camera {
  const free_width_px = Math.max(size.width_px - padding.left - padding.right, 40);
  const free_height_px = Math.max(size.height_px - padding.top - padding.bottom, 40);
  const px_per_m = Math.min(
    free_width_px / Math.max(bounds.x_max_m - bounds.x_min_m, 1),
    free_height_px / Math.max(bounds.y_max_m - bounds.y_min_m, 1),
    FIT_PX_PER_M_MAX,
  );
  const offset_x_px = (padding.left - padding.right) / 2;
  const offset_y_px = (padding.top - padding.bottom) / 2;
  return {
    x_m: (bounds.x_min_m + bounds.x_max_m) / 2 - offset_x_px / px_per_m,
    y_m: (bounds.y_min_m + bounds.y_max_m) / 2 + offset_y_px / px_per_m,
    px_per_m,
  };
}
