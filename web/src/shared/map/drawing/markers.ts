import type { Condition } from "../../scene/condition";
import { urgencyOf } from "../../scene/condition";
import type { Palette } from "./palette";
import type { Sprites } from "./sprites";

export type StopRole = "plain" | "pickup" | "destination";

const BODY_LENGTH_M = 4.35;
const BODY_WIDTH_M = 1.63;
/** A shuttle stays visible at every zoom. */
const BODY_PX_MIN = 20;

/** A stop is a dot, the pickup a ring and the destination a square: the shape tells them apart without colour. */
export function drawStop(
  context: CanvasRenderingContext2D,
  palette: Palette,
  x: number,
  y: number,
  role: StopRole,
): void {
  context.lineWidth = 2;
  context.strokeStyle = palette.halo;
  context.beginPath();
  if (role === "destination") {
    context.fillStyle = palette.destination;
    context.roundRect(x - 8, y - 8, 16, 16, 3);
    context.fill();
    context.stroke();
    return;
  }
  context.arc(x, y, role === "pickup" ? 9 : 5, 0, 2 * Math.PI);
  context.fillStyle = role === "pickup" ? palette.pickup : palette.stop;
  context.fill();
  context.stroke();
  if (role === "pickup") {
    context.beginPath();
    context.arc(x, y, 3.5, 0, 2 * Math.PI);
    context.fillStyle = palette.halo;
    context.fill();
  }
}

/** The radius of a stop's marker. */
export function stopRadius_px(role: StopRole): number {
  return role === "plain" ? 6 : 10;
}

export function bodyLength_px(px_per_m: number): number {
  return Math.max(BODY_LENGTH_M * px_per_m, BODY_PX_MIN);
}

function ringRadius_px(length_px: number): number {
  return length_px * 0.72 + 4;
}

/** The radius of a shuttle's marker, with the ring of a selected one. */
export function vehicleRadius_px(length_px: number, selected: boolean): number {
  return selected ? ringRadius_px(length_px) + 2 : length_px * 0.55 + 4;
}

export interface VehicleMarker {
  readonly x: number;
  readonly y: number;
  readonly heading_rad: number;
  readonly length: number;
  readonly condition: Condition;
  readonly selected: boolean;
}

/** Headings of copied markers: 5.6 degrees apart, which no eye sees at this size. */
const HEADINGS = 64;
/** Larger ones are drawn as paths: there are few of them on a screen. */
const SPRITE_PX_MAX = 48;
const BADGE_PX = 20;

/** As drawVehicle, copied from a picture of this condition and heading. */
export function drawVehicleSprite(
  context: CanvasRenderingContext2D,
  palette: Palette,
  sprites: Sprites,
  marker: VehicleMarker,
): void {
  const length = Math.round(marker.length);
  if (marker.selected || length > SPRITE_PX_MAX) {
    drawVehicle(context, palette, marker);
    return;
  }
  const turns = marker.heading_rad / (2 * Math.PI);
  const heading = (((Math.round(turns * HEADINGS) % HEADINGS) + HEADINGS) % HEADINGS) / HEADINGS;
  const side_px = length + BADGE_PX + 4;
  const sprite = sprites.get(
    `vehicle ${marker.condition} ${length} ${heading}`,
    () => [side_px, side_px],
    (picture) =>
      drawVehicle(picture, palette, {
        ...marker,
        x: 0,
        y: 0,
        length,
        heading_rad: 2 * Math.PI * heading,
      }),
  );
  sprites.copy(context, sprite, marker.x, marker.y);
}

/** A shuttle seen from above; heading_rad is counter-clockwise from the screen's right. */
export function drawVehicle(
  context: CanvasRenderingContext2D,
  palette: Palette,
  marker: VehicleMarker,
): void {
  const { length } = marker;
  const width = Math.max((length * BODY_WIDTH_M) / BODY_LENGTH_M, 11);
  context.save();
  context.translate(marker.x, marker.y);
  if (marker.selected) drawRing(context, palette, ringRadius_px(length));
  context.rotate(-marker.heading_rad);
  context.beginPath();
  context.roundRect(-length / 2, -width / 2, length * 0.78, width, width * 0.28);
  context.moveTo(length * 0.2, -width / 2);
  context.lineTo(length / 2 + 1, 0);
  context.lineTo(length * 0.2, width / 2);
  context.closePath();
  context.fillStyle = palette.vehicle[urgencyOf(marker.condition)];
  context.strokeStyle = palette.halo;
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.stroke();
  context.fill();
  context.rotate(marker.heading_rad);
  drawBadge(context, palette, marker.condition, length);
  context.restore();
}

function drawRing(context: CanvasRenderingContext2D, palette: Palette, radius: number): void {
  context.beginPath();
  context.arc(0, 0, radius, 0, 2 * Math.PI);
  context.strokeStyle = palette.ink;
  context.lineWidth = 2;
  context.stroke();
}

const BADGES: Partial<Record<Condition, string>> = {
  offline: "?",
  fault: "!",
  minimal_risk: "!",
  manual: "M",
  held: "II",
  blocked: "!",
  waiting: "…",
};

/** A badge shows an unusual condition without colour. */
function drawBadge(
  context: CanvasRenderingContext2D,
  palette: Palette,
  condition: Condition,
  length: number,
): void {
  const badge = BADGES[condition];
  if (badge === undefined) return;
  const offset = length * 0.36 + 3;
  context.beginPath();
  context.arc(offset, -offset, 8, 0, 2 * Math.PI);
  context.fillStyle = palette.vehicle[urgencyOf(condition)];
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = palette.halo;
  context.stroke();
  context.fillStyle = palette.on_vehicle;
  context.font = `700 10px ${palette.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(badge, offset, -offset + 0.5);
}
