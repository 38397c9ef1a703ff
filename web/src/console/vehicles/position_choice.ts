import { signal } from "@preact/signals";
import type { Camera } from "../../shared/map/camera/camera";
import type { Palette } from "../../shared/map/drawing/palette";
import type { Point } from "../../shared/scene/scene";

/** A place on the map that an operator names for a shuttle: first where it stands, then where it looks. */
export interface PositionChoice {
  readonly vehicle_id: string;
  readonly at: Point | null;
  readonly towards: Point | null;
}

export interface Pose {
  readonly x_m: number;
  readonly y_m: number;
  readonly yaw_rad: number;
}

/** The choice under way; null: clicks on the map select shuttles. */
export const position_choice = signal<PositionChoice | null>(null);

export function beginChoice(vehicle_id: string): void {
  position_choice.value = { vehicle_id, at: null, towards: null };
}

export function endChoice(): void {
  position_choice.value = null;
}

/** A click on the ground: the place, then the direction; a third one begins again. */
export function afterClick(choice: PositionChoice, point: Point): PositionChoice {
  if (choice.at === null || choice.towards !== null) return { ...choice, at: point, towards: null };
  return { ...choice, towards: point };
}

/** Where the shuttle stands and looks; null before both are chosen. */
export function poseOf({ at, towards }: PositionChoice): Pose | null {
  if (at === null || towards === null) return null;
  return { x_m: at[0], y_m: at[1], yaw_rad: Math.atan2(towards[1] - at[1], towards[0] - at[0]) };
}

const RING_PX = 9;
const LINE_PX = 3;
const ARROW_PX = 44;

/** A ring at the place and an arrow to where the shuttle looks. */
export function drawChoice(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  choice: PositionChoice,
): void {
  if (choice.at === null) return;
  const [x, y] = choice.at;
  const m = 1 / camera.px_per_m;
  context.lineWidth = LINE_PX * m;
  context.strokeStyle = palette.closed_road;
  const shape = new Path2D();
  shape.arc(x, y, RING_PX * m, 0, 2 * Math.PI);
  const pose = poseOf(choice);
  if (pose !== null) {
    const tip: Point = [
      x + ARROW_PX * m * Math.cos(pose.yaw_rad),
      y + ARROW_PX * m * Math.sin(pose.yaw_rad),
    ];
    shape.moveTo(x, y);
    shape.lineTo(...tip);
    for (const turn of [2.6, -2.6]) {
      shape.moveTo(...tip);
      shape.lineTo(
        tip[0] + RING_PX * m * Math.cos(pose.yaw_rad + turn),
        tip[1] + RING_PX * m * Math.sin(pose.yaw_rad + turn),
      );
    }
  }
  context.stroke(shape);
}
