import type { CampusGeometry } from "../campus/campus_geometry";
import { pointsOf } from "../campus/campus_geometry";
import type { Camera } from "./camera/camera";
import { drawLine } from "./drawing/base_map";
import type { Palette } from "./drawing/palette";
import type { MapLayer } from "./map_content";
import type { AreaObservation } from "../scene/observation_areas";
import { areaObservations } from "../scene/observation_areas";
import type { DrivingView, Scene } from "../scene/scene";

/** At this zoom and above, single people are drawn. */
const PEOPLE_FROM_PX_PER_M = 1.5;
const PERSON_PX_MIN = 7;
const PATH_PX = 3;
const PREDICTION_PX = 1.5;
const AREA_PX = 2;
const DASH_PX = 6;

type Track = DrivingView["tracks"][number];

/**
 * Draws observation areas with their state, planned paths, and tracks of people with their predicted paths.
 * `at_ms` is the scene's clock, by which a camera's report becomes stale. Of `detailed_vehicle` only predictions are
 * drawn: its tracks are drawn in detail by another layer.
 */
export function drivingLayer(
  scene: Scene,
  at_ms: number,
  selected_vehicle: string,
  detailed_vehicle = "",
): MapLayer {
  const observations = areaObservations(scene, at_ms);
  return (context, camera, palette, geometry) => {
    drawAreas(context, camera, palette, geometry.areas, observations);
    drawPlansAndTracks(context, camera, palette, scene, selected_vehicle, detailed_vehicle);
  };
}

function drawAreas(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  outlines: CampusGeometry["areas"],
  observations: readonly AreaObservation[],
): void {
  for (const area of observations) {
    if (area.camera_count === null && camera.px_per_m < PEOPLE_FROM_PX_PER_M) continue;
    const corners = outlines.get(area.area_id);
    if (corners === undefined) continue;
    const outline = new Path2D();
    corners.forEach(([x, y], index) => (index === 0 ? outline.moveTo(x, y) : outline.lineTo(x, y)));
    outline.closePath();
    const colour = palette.area[area.state];
    context.globalAlpha = area.state === "unknown" ? 0.08 : 0.2;
    context.fillStyle = colour;
    context.fill(outline);
    context.globalAlpha = area.state === "unknown" && !area.seen_by_vehicle ? 0.6 : 1;
    context.lineWidth =
      (area.seen_by_vehicle || area.state !== "unknown" ? AREA_PX : 1) / camera.px_per_m;
    context.strokeStyle = area.seen_by_vehicle ? palette.area.occupied : colour;
    // Without a current report the edge is dashed: colour alone would not show it.
    context.setLineDash(area.state === "unknown" ? [dash_m(camera), dash_m(camera)] : []);
    context.stroke(outline);
    context.setLineDash([]);
    context.globalAlpha = 1;
  }
}

/** What shuttles plan and perceive: the planned path, and tracks with their predicted paths. */
function drawPlansAndTracks(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  scene: Scene,
  selected_vehicle: string,
  detailed_vehicle: string,
): void {
  for (const vehicle of scene.vehicles) {
    const driving = vehicle.status?.driving;
    if (!driving || !vehicle.facts.connected) continue;
    context.globalAlpha =
      vehicle.vehicle_id === selected_vehicle || selected_vehicle === "" ? 1 : 0.4;
    drawLine(context, camera, pointsOf(driving.path), palette.path, PATH_PX);
    if (camera.px_per_m >= PEOPLE_FROM_PX_PER_M)
      for (const track of driving.tracks)
        drawTrack(context, camera, palette, track, vehicle.vehicle_id !== detailed_vehicle);
  }
  context.globalAlpha = 1;
}

function drawTrack(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  track: Track,
  with_body: boolean,
): void {
  const [, kind, x, y, yaw_rad, length_m, width_m, yielded_to, prediction] = track;
  const colour = yielded_to ? palette.yielded_to : palette.people;
  if (prediction && prediction.length > 0) {
    context.setLineDash([dash_m(camera) / 2, dash_m(camera) / 2]);
    drawLine(context, camera, [[x, y], ...pointsOf(prediction)], colour, PREDICTION_PX);
    context.setLineDash([]);
  }
  if (!with_body) return;
  const size_m_min = PERSON_PX_MIN / camera.px_per_m;
  context.beginPath();
  if (kind === "pedestrian") {
    context.arc(x, y, Math.max(length_m, size_m_min) / 2, 0, 2 * Math.PI);
  } else {
    const [cos, sin] = [Math.cos(yaw_rad) / 2, Math.sin(yaw_rad) / 2];
    const [length, width] = [Math.max(length_m, size_m_min), Math.max(width_m, size_m_min)];
    for (const [u, v] of CORNERS)
      context.lineTo(
        x + u * length * cos - v * width * sin,
        y + u * length * sin + v * width * cos,
      );
    context.closePath();
  }
  context.fillStyle = colour;
  context.fill();
  context.strokeStyle = palette.halo;
  context.lineWidth = 1 / camera.px_per_m;
  context.stroke();
}

const CORNERS = [
  [1, 1],
  [-1, 1],
  [-1, -1],
  [1, -1],
] as const;

function dash_m(camera: Camera): number {
  return DASH_PX / camera.px_per_m;
}
