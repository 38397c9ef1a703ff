import type { Size } from "../camera/camera";
import type { Palette } from "./palette";

export interface Label {
  readonly text: string;
  /** Where the labelled thing is on the screen, and how far its mark reaches from there. */
  readonly x_px: number;
  readonly y_px: number;
  readonly reach_px: number;
  readonly strong: boolean;
}

interface Box {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

const TEXT_PX = 12;
const HEIGHT_PX = 16;

/**
 * Writes labels in the order given, each beside, above or below its mark, and leaves out what would
 * cover an earlier one or reach over the edge: the most important come first.
 */
export function drawLabels(
  pen: CanvasRenderingContext2D,
  palette: Palette,
  labels: readonly Label[],
  size: Size,
): void {
  const marks = labels.map((label) => around(label.x_px, label.y_px, label.reach_px));
  const taken: Box[] = [...marks, ...furniture(size)];
  pen.textBaseline = "middle";
  pen.textAlign = "left";
  pen.lineJoin = "round";
  for (const [index, label] of labels.entries()) {
    pen.font = `${label.strong ? 600 : 400} ${TEXT_PX}px ${palette.font}`;
    const own = marks[index];
    const box = placesFor(label, pen.measureText(label.text).width).find(
      (place) =>
        inside(place, size) && !taken.some((other) => other !== own && overlap(place, other)),
    );
    if (box === undefined) continue;
    taken.push(box);
    const middle = (box.top + box.bottom) / 2;
    pen.strokeStyle = palette.halo;
    pen.lineWidth = 4;
    pen.strokeText(label.text, box.left, middle);
    pen.fillStyle = palette.ink;
    pen.fillText(label.text, box.left, middle);
  }
}

export function placesFor(label: Label, width_px: number): Box[] {
  const gap = label.reach_px + 3;
  const at = (left: number, top: number): Box => ({
    left,
    top,
    right: left + width_px,
    bottom: top + HEIGHT_PX,
  });
  const middle = label.y_px - HEIGHT_PX / 2;
  const centred = label.x_px - width_px / 2;
  return [
    at(label.x_px + gap, middle),
    at(label.x_px - gap - width_px, middle),
    at(centred, label.y_px + gap),
    at(centred, label.y_px - gap - HEIGHT_PX),
    at(label.x_px - label.reach_px, label.y_px + gap),
    at(label.x_px - label.reach_px, label.y_px - gap - HEIGHT_PX),
    at(label.x_px + label.reach_px - width_px, label.y_px + gap),
    at(label.x_px + label.reach_px - width_px, label.y_px - gap - HEIGHT_PX),
  ];
}

/** The zoom buttons and the map's credit, which lie over the canvas. */
function furniture(size: Size): Box[] {
  const { width_px, height_px } = size;
  return [
    { left: width_px - 62, top: 0, right: width_px, bottom: 206 },
    { left: 0, top: height_px - 22, right: 260, bottom: height_px },
  ];
}

function around(x: number, y: number, reach: number): Box {
  return { left: x - reach, top: y - reach, right: x + reach, bottom: y + reach };
}

function inside(box: Box, size: Size): boolean {
  return (
    box.left >= 0 && box.top >= 0 && box.right <= size.width_px && box.bottom <= size.height_px
  );
}

function overlap(a: Box, b: Box): boolean {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}
