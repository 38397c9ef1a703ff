import type { Size } from "../camera/camera";
import type { Box } from "./box_grid";
import { BoxGrid } from "./box_grid";
import type { Palette } from "./palette";
import type { Sprite, Sprites } from "./sprites";

export interface Label {
  readonly text: string;
  /** The centre of the labelled marker on the screen, and its radius. */
  readonly x_px: number;
  readonly y_px: number;
  readonly radius_px: number;
  readonly strong: boolean;
}

/** The height of a line of text, of its size. */
const LINE = 4 / 3;

/** Of more labels than this only the first are looked at: a place for the others would hardly be found. */
const CONSIDERED_MAX = 200;
const HALO_PX = 4;

/**
 * Draws labels beside their markers, in the order of their importance. A label that would cover a marker or
 * an earlier one or cross the edge is left out.
 */
export function drawLabels(
  context: CanvasRenderingContext2D,
  palette: Palette,
  sprites: Sprites,
  labels: readonly Label[],
  size: Size,
): void {
  const markers = labels.map((label) => boxAround(label.x_px, label.y_px, label.radius_px));
  const occupied = new BoxGrid();
  for (const box of [...markers, ...overlayBoxes(size)]) occupied.add(box);
  const height_px = LINE * palette.text_px;
  for (const [index, label] of labels.slice(0, CONSIDERED_MAX).entries()) {
    const sprite = labelSprite(context, palette, sprites, label, height_px);
    const width_px = sprite.width_px - 2 * HALO_PX;
    const box = candidateBoxes(label, width_px, height_px).find(
      (candidate) => isInside(candidate, size) && !occupied.isTaken(candidate, markers[index]),
    );
    if (box === undefined) continue;
    occupied.add(box);
    sprites.copy(context, sprite, (box.left + box.right) / 2, (box.top + box.bottom) / 2);
  }
}

function labelSprite(
  context: CanvasRenderingContext2D,
  palette: Palette,
  sprites: Sprites,
  { text, strong }: Label,
  height_px: number,
): Sprite {
  const font = `${strong ? 600 : 400} ${palette.text_px}px ${palette.font}`;
  const measured = () => {
    context.font = font;
    return [context.measureText(text).width + 2 * HALO_PX, height_px + 2 * HALO_PX] as const;
  };
  return sprites.get(`label ${strong} ${text}`, measured, (picture) => {
    picture.font = font;
    picture.textBaseline = "middle";
    picture.textAlign = "center";
    picture.lineJoin = "round";
    picture.strokeStyle = palette.halo;
    picture.lineWidth = HALO_PX;
    picture.strokeText(text, 0, 0);
    picture.fillStyle = palette.ink;
    picture.fillText(text, 0, 0);
  });
}

function candidateBoxes(label: Label, width_px: number, height_px: number): Box[] {
  const gap = label.radius_px + 3;
  const at = (left: number, top: number): Box => ({
    left,
    top,
    right: left + width_px,
    bottom: top + height_px,
  });
  const middle = label.y_px - height_px / 2;
  const centred = label.x_px - width_px / 2;
  return [
    at(label.x_px + gap, middle),
    at(label.x_px - gap - width_px, middle),
    at(centred, label.y_px + gap),
    at(centred, label.y_px - gap - height_px),
    at(label.x_px - label.radius_px, label.y_px + gap),
    at(label.x_px - label.radius_px, label.y_px - gap - height_px),
    at(label.x_px + label.radius_px - width_px, label.y_px + gap),
    at(label.x_px + label.radius_px - width_px, label.y_px - gap - height_px),
  ];
}

/** The boxes of the zoom buttons and of the attribution, which lie over the canvas. */
function overlayBoxes(size: Size): Box[] {
  const { width_px, height_px } = size;
  return [
    { left: width_px - 62, top: 0, right: width_px, bottom: 206 },
    { left: 0, top: height_px - 22, right: 260, bottom: height_px },
  ];
}

function boxAround(x: number, y: number, radius: number): Box {
  return { left: x - radius, top: y - radius, right: x + radius, bottom: y + radius };
}

function isInside(box: Box, size: Size): boolean {
  return (
    box.left >= 0 && box.top >= 0 && box.right <= size.width_px && box.bottom <= size.height_px
  );
}
