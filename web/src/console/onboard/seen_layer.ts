import type { Camera } from "../../shared/map/camera/camera";
import { drawLine } from "../../shared/map/drawing/base_map";
import type { Palette } from "../../shared/map/drawing/palette";
import type { MapLayer } from "../../shared/map/map_content";
import type { OnboardScene } from "../../shared/scene/onboard_scene";
import type { Point } from "../../shared/scene/scene";
import {
  arrowOf,
  barbsOf,
  cornersOf,
  heightBand,
  kindOf,
  scanPoints,
  type ShownSign,
  type ShownTrack,
  signOutline,
} from "./seen_things";

/** Cells of the vehicle's height map are about so large. */
const CELL_M = 0.2;
const CELL_PX_MIN = 2;
const POINT_PX = 1.5;
const TRACK_PX_MIN = 9;
/** From this zoom on tracks and signs are drawn, and from the next on their numbers. */
const THINGS_FROM_PX_PER_M = 1.5;
const NUMBERS_FROM_PX_PER_M = 6;
const SIGN_PX = 9;
const BARB_PX = 7;

/** Draws what the lidar found above the ground: obstacle cells, and below them points of the last scan. */
export function pointsLayer({ points = [], scan = null }: OnboardScene): MapLayer {
  const scanned = scan === null ? null : scanPoints(scan);
  return (context, camera, palette) => {
    if (scanned !== null) {
      const size_m = POINT_PX / camera.px_per_m;
      // What is higher is drawn over what is lower, as it is seen from above.
      for (const [band, colour] of palette.seen.points.entries()) {
        context.fillStyle = colour;
        for (let k = 0; k + 2 < scanned.length; k += 3)
          if (heightBand(scanned[k + 2]!) === band)
            context.fillRect(
              scanned[k]! - size_m / 2,
              scanned[k + 1]! - size_m / 2,
              size_m,
              size_m,
            );
      }
    }
    const size_m = Math.max(CELL_M, CELL_PX_MIN / camera.px_per_m);
    context.fillStyle = palette.ink;
    context.globalAlpha = 0.7;
    context.beginPath();
    for (let k = 0; k + 1 < points.length; k += 2)
      context.rect(points[k]! - size_m / 2, points[k + 1]! - size_m / 2, size_m, size_m);
    context.fill();
    context.globalAlpha = 1;
  };
}

/** Draws road users as the shuttle tracks them, and traffic signs. */
export function seenLayer({ tracks = [], signs = [], tracks_by = "" }: OnboardScene): MapLayer {
  return (context, camera, palette) => {
    if (camera.px_per_m < THINGS_FROM_PX_PER_M) return;
    for (const track of tracks) drawTrack(context, camera, palette, track, tracks_by === "own");
    for (const sign of signs) drawSign(context, camera, palette, sign);
  };
}

/** A person is a disc. The outline is dashed where another computer tracks, and red for what is yielded to. */
function drawTrack(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  track: ShownTrack,
  is_own: boolean,
): void {
  const kind = kindOf(track);
  const [track_id, , x, y, , length_m, , , , yielded_to] = track;
  const px_m = 1 / camera.px_per_m;
  const arrow = arrowOf(track);
  if (arrow !== null) {
    const [left, right] = barbsOf(arrow, BARB_PX * px_m);
    for (const [colour, width_px] of [
      [palette.halo, 4],
      [palette.seen[kind], 2],
    ] as const) {
      drawLine(context, camera, arrow, colour, width_px);
      drawLine(context, camera, [left, arrow[1], right], colour, width_px);
    }
  }
  context.beginPath();
  if (kind === "pedestrian")
    context.arc(x, y, Math.max(length_m, TRACK_PX_MIN * px_m) / 2, 0, 2 * Math.PI);
  else {
    for (const corner of cornersOf(track, TRACK_PX_MIN * px_m)) context.lineTo(...corner);
    context.closePath();
  }
  context.strokeStyle = palette.halo;
  context.lineWidth = 5 * px_m;
  context.stroke();
  context.fillStyle = palette.seen[kind];
  context.fill();
  context.strokeStyle = yielded_to ? palette.yielded_to : palette.ink;
  context.lineWidth = (yielded_to ? 3 : 1.5) * px_m;
  context.setLineDash(is_own ? [] : [4 * px_m, 3 * px_m]);
  context.stroke();
  context.setLineDash([]);
  if (camera.px_per_m >= NUMBERS_FROM_PX_PER_M)
    drawText(context, camera, palette, [x, y], 14, String(track_id));
}

/** The symbol lies at its place whatever the zoom; a short line points to where its face looks. */
function drawSign(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  [, kind, x, y, yaw_rad, distance_m]: ShownSign,
): void {
  const px_m = 1 / camera.px_per_m;
  const reach_m = 1.9 * SIGN_PX * px_m;
  const tip: Point = [x + reach_m * Math.cos(yaw_rad), y + reach_m * Math.sin(yaw_rad)];
  drawLine(context, camera, [[x, y], tip], palette.halo, 4);
  drawLine(context, camera, [[x, y], tip], palette.ink, 2);
  context.save();
  context.translate(x, y);
  context.scale(px_m, -px_m);
  context.beginPath();
  for (const corner of signOutline(kind, SIGN_PX)) context.lineTo(...corner);
  context.closePath();
  const is_read = kind === "stop" || kind === "yield";
  context.fillStyle = kind === "stop" ? palette.seen.stop : palette.halo;
  context.lineJoin = "round";
  context.strokeStyle = palette.halo;
  context.lineWidth = 5;
  context.stroke();
  context.fill();
  context.strokeStyle = is_read ? palette.seen.stop : palette.ink;
  context.lineWidth = 2.5;
  context.setLineDash(kind === "board" ? [3, 2] : []);
  context.stroke();
  context.setLineDash([]);
  context.fillStyle = kind === "stop" ? palette.halo : palette.ink;
  if (kind === "stop") context.fillRect(-5, -1.5, 10, 3);
  if (kind === "board") {
    context.font = `700 11px ${palette.font}`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText("?", 0, 0.5);
  }
  context.restore();
  if (camera.px_per_m >= NUMBERS_FROM_PX_PER_M)
    drawText(context, camera, palette, [x, y], 20, `${distance_m.toFixed(0)} m`);
}

/** `below_px`: how far the text is below its place. */
function drawText(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  [x, y]: Point,
  below_px: number,
  text: string,
): void {
  context.save();
  context.translate(x, y);
  context.scale(1 / camera.px_per_m, -1 / camera.px_per_m);
  context.font = `600 ${palette.text_px}px ${palette.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.strokeStyle = palette.halo;
  context.strokeText(text, 0, below_px);
  context.fillStyle = palette.ink;
  context.fillText(text, 0, below_px);
  context.restore();
}
