import type { Size } from "./camera";
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
 * Writes labels in the order given, each right of, left of, above or below its mark, and leaves out what would
 * cover an earlier one or reach over the edge: the most important come first.
 */
export function drawLabels(
  pen: CanvasRenderingContext2D,
  palette: Palette,
  labels: readonly Label[],
  size: Size,
): void {
  const taken: Box[] = labels.map((label) => around(label.x_px, label.y_px, label.reach_px));
  pen.textBaseline = "middle";
  pen.textAlign = "left";
  pen.lineJoin = "round";
  for (const label of labels) {
    pen.font = `${label.strong ? 600 : 400} ${TEXT_PX}px ${palette.font}`;
    const own = taken[labels.indexOf(label)];
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
