import type { Condition } from "../../scene/condition";
import { urgencyOf } from "../../scene/condition";
import type { Palette } from "./palette";

export type StopRole = "plain" | "pickup" | "destination";

const BODY_LENGTH_M = 4.35;
const BODY_WIDTH_M = 1.63;
/** A shuttle stays findable however far out one looks. */
const BODY_PX_MIN = 20;

/** A dot; the pickup is a ring and the destination a square, so that colour is not needed to tell. */
export function drawStop(
  pen: CanvasRenderingContext2D,
  palette: Palette,
  x: number,
  y: number,
  role: StopRole,
): void {
  pen.lineWidth = 2;
  pen.strokeStyle = palette.halo;
  pen.beginPath();
  if (role === "destination") {
    pen.fillStyle = palette.destination;
    pen.roundRect(x - 8, y - 8, 16, 16, 3);
    pen.fill();
    pen.stroke();
    return;
  }
  pen.arc(x, y, role === "pickup" ? 9 : 5, 0, 2 * Math.PI);
  pen.fillStyle = role === "pickup" ? palette.pickup : palette.stop;
  pen.fill();
  pen.stroke();
  if (role === "pickup") {
    pen.beginPath();
    pen.arc(x, y, 3.5, 0, 2 * Math.PI);
    pen.fillStyle = palette.halo;
    pen.fill();
  }
}

/** How far a stop's mark reaches from its centre. */
export function stopReach_px(role: StopRole): number {
  return role === "plain" ? 6 : 10;
}

export function bodyLength_px(px_per_m: number): number {
  return Math.max(BODY_LENGTH_M * px_per_m, BODY_PX_MIN);
}

function ringRadius_px(length_px: number): number {
  return length_px * 0.72 + 4;
}

/** How far a shuttle's mark, with its ring when it is chosen, reaches from its centre. */
export function vehicleReach_px(length_px: number, chosen: boolean): number {
  return chosen ? ringRadius_px(length_px) + 2 : length_px * 0.55 + 4;
}

/** A shuttle seen from above, its nose forward; heading_rad is counter-clockwise from the screen's right. */
export function drawVehicle(
  pen: CanvasRenderingContext2D,
  palette: Palette,
  mark: {
    readonly x: number;
    readonly y: number;
    readonly heading_rad: number;
    readonly length: number;
    readonly condition: Condition;
    readonly chosen: boolean;
  },
): void {
  const { length } = mark;
  const width = Math.max((length * BODY_WIDTH_M) / BODY_LENGTH_M, 11);
  pen.save();
  pen.translate(mark.x, mark.y);
  if (mark.chosen) ring(pen, palette, ringRadius_px(length));
  pen.rotate(-mark.heading_rad);
  pen.beginPath();
  pen.roundRect(-length / 2, -width / 2, length * 0.78, width, width * 0.28);
  pen.moveTo(length * 0.2, -width / 2);
  pen.lineTo(length / 2 + 1, 0);
  pen.lineTo(length * 0.2, width / 2);
  pen.closePath();
  pen.fillStyle = palette.vehicle[urgencyOf(mark.condition)];
  pen.strokeStyle = palette.halo;
  pen.lineJoin = "round";
  pen.lineWidth = 3;
  pen.stroke();
  pen.fill();
  pen.rotate(mark.heading_rad);
  drawSign(pen, palette, mark.condition, length);
  pen.restore();
}

function ring(pen: CanvasRenderingContext2D, palette: Palette, radius: number): void {
  pen.beginPath();
  pen.arc(0, 0, radius, 0, 2 * Math.PI);
  pen.strokeStyle = palette.ink;
  pen.lineWidth = 2;
  pen.stroke();
}

const SIGNS: Partial<Record<Condition, string>> = {
  offline: "?",
  fault: "!",
  minimal_risk: "!",
  manual: "M",
  held: "II",
  blocked: "!",
  waiting: "…",
};

/** The badge that says without colour that something is not as usual. */
function drawSign(
  pen: CanvasRenderingContext2D,
  palette: Palette,
  condition: Condition,
  length: number,
): void {
  const sign = SIGNS[condition];
  if (sign === undefined) return;
  const off = length * 0.36 + 3;
  pen.beginPath();
  pen.arc(off, -off, 8, 0, 2 * Math.PI);
  pen.fillStyle = palette.vehicle[urgencyOf(condition)];
  pen.fill();
  pen.lineWidth = 1.5;
  pen.strokeStyle = palette.halo;
  pen.stroke();
  pen.fillStyle = palette.on_vehicle;
  pen.font = `700 10px ${palette.font}`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(sign, off, -off + 0.5);
}
