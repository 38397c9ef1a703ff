import type { Size } from "../camera/camera";
import type { Palette } from "./palette";

export interface Label {
  readonly text: string;
  /** The centre of the labelled marker on the screen, and its radius. */
  readonly x_px: number;
  readonly y_px: number;
  readonly radius_px: number;
  readonly strong: boolean;
}

interface Box {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

/** The height of a line of text, of its size. */
const LINE = 4 / 3;

/**
 * Writes the labels, the most important first, each beside, above or below its marker. A label that would cover
 * an earlier one or cross the edge is left out.
 */
export function drawLabels(
  context: CanvasRenderingContext2D,
  palette: Palette,
  labels: readonly Label[],
  size: Size,
): void {
  const markers = labels.map((label) => boxAround(label.x_px, label.y_px, label.radius_px));
  const height_px = LINE * palette.text_px;
  const occupied: Box[] = [...markers, ...overlayBoxes(size)];
  context.textBaseline = "middle";
  context.textAlign = "left";
  context.lineJoin = "round";
  for (const [index, label] of labels.entries()) {
    context.font = `${label.strong ? 600 : 400} ${palette.text_px}px ${palette.font}`;
    const own = markers[index];
    const box = candidateBoxes(label, context.measureText(label.text).width, height_px).find(
      (candidate) =>
        isInside(candidate, size) &&
        !occupied.some((other) => other !== own && overlaps(candidate, other)),
    );
    if (box === undefined) continue;
    occupied.push(box);
    const middle = (box.top + box.bottom) / 2;
    context.strokeStyle = palette.halo;
    context.lineWidth = 4;
    context.strokeText(label.text, box.left, middle);
    context.fillStyle = palette.ink;
    context.fillText(label.text, box.left, middle);
  }
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

function overlaps(a: Box, b: Box): boolean {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}
