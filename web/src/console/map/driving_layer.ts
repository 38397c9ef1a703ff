import type { CampusShape } from "../../shared/campus/campus_geometry";
import { pairs } from "../../shared/campus/campus_geometry";
import type { Camera } from "../../shared/map/camera/camera";
import { drawLine } from "../../shared/map/drawing/base_map";
import type { Palette } from "../../shared/map/drawing/palette";
import type { Layer } from "../../shared/map/map_view";
import type { Watched } from "../../shared/scene/observation_areas";
import { watchedAreas } from "../../shared/scene/observation_areas";
import type { Scene, VehicleScene } from "../../shared/scene/scene";

/** From here on single people can be told apart. */
const PEOPLE_FROM_PX_PER_M = 1.5;
const PERSON_PX_MIN = 7;
const PATH_PX = 3;
const AHEAD_PX = 1.5;
const AREA_PX = 2;
const DASH_PX = 6;

type Track = NonNullable<VehicleScene["picture"]>["tracks"][number];

/**
 * What operators look at beside the shuttles: observation areas with their state, planned paths, people and
 * where they are expected; `at_ms` is the scene's clock, by which a camera's report becomes stale.
 */
export function drivingLayer(scene: Scene, at_ms: number, chosen: string): Layer {
  const watched = watchedAreas(scene, at_ms);
  return (pen, camera, palette, shape) => {
    drawAreas(pen, camera, palette, shape.areas, watched);
    drawPictures(pen, camera, palette, scene, chosen);
  };
}

function drawAreas(
  pen: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  outlines: CampusShape["areas"],
  watched: readonly Watched[],
): void {
  for (const area of watched) {
    if (area.told === null && camera.px_per_m < PEOPLE_FROM_PX_PER_M) continue;
    const outline = outlines.get(area.area_id);
    if (outline === undefined) continue;
    const shape = new Path2D();
    outline.forEach(([x, y], index) => (index === 0 ? shape.moveTo(x, y) : shape.lineTo(x, y)));
    shape.closePath();
    const colour = palette.area[area.state];
    pen.globalAlpha = area.state === "unknown" ? 0.08 : 0.2;
    pen.fillStyle = colour;
    pen.fill(shape);
    pen.globalAlpha = 1;
    pen.globalAlpha = area.state === "unknown" && !area.seen ? 0.6 : 1;
    pen.lineWidth = (area.seen || area.state !== "unknown" ? AREA_PX : 1) / camera.px_per_m;
    pen.strokeStyle = area.seen ? palette.area.occupied : colour;
    // What no camera vouches for is dashed: colour alone would not tell.
    pen.setLineDash(area.state === "unknown" ? [dash(camera), dash(camera)] : []);
    pen.stroke(shape);
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }
}

/** What shuttles see and mean to do: the planned path, people, and where they are expected. */
function drawPictures(
  pen: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  scene: Scene,
  chosen: string,
): void {
  for (const vehicle of scene.vehicles) {
    const picture = vehicle.picture;
    if (!picture || !vehicle.located || !vehicle.connected) continue;
    pen.globalAlpha = vehicle.vehicle_id === chosen || chosen === "" ? 1 : 0.4;
    drawLine(pen, camera, pairs(picture.path), palette.path, PATH_PX);
    if (camera.px_per_m >= PEOPLE_FROM_PX_PER_M)
      for (const track of picture.tracks) drawTrack(pen, camera, palette, track);
  }
  pen.globalAlpha = 1;
}

function drawTrack(
  pen: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  track: Track,
): void {
  const [, kind, x, y, yaw_rad, length_m, width_m, yielded_to, ahead] = track;
  const colour = yielded_to ? palette.yielded_to : palette.people;
  if (ahead && ahead.length > 0) {
    pen.setLineDash([dash(camera) / 2, dash(camera) / 2]);
    drawLine(pen, camera, [[x, y], ...pairs(ahead)], colour, AHEAD_PX);
    pen.setLineDash([]);
  }
  const least_m = PERSON_PX_MIN / camera.px_per_m;
  pen.beginPath();
  if (kind === "pedestrian") {
    pen.arc(x, y, Math.max(length_m, least_m) / 2, 0, 2 * Math.PI);
  } else {
    const [cos, sin] = [Math.cos(yaw_rad) / 2, Math.sin(yaw_rad) / 2];
    const [long, wide] = [Math.max(length_m, least_m), Math.max(width_m, least_m)];
    for (const [u, v] of CORNERS)
      pen.lineTo(x + u * long * cos - v * wide * sin, y + u * long * sin + v * wide * cos);
    pen.closePath();
  }
  pen.fillStyle = colour;
  pen.fill();
  pen.strokeStyle = palette.halo;
  pen.lineWidth = 1 / camera.px_per_m;
  pen.stroke();
}

const CORNERS = [
  [1, 1],
  [-1, 1],
  [-1, -1],
  [1, -1],
] as const;

function dash(camera: Camera): number {
  return DASH_PX / camera.px_per_m;
}
