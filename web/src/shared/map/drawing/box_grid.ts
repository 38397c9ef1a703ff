export interface Box {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

const CELL_PX = 64;

/** Boxes on the screen, found by the cells that they touch. */
export class BoxGrid {
  private readonly cells = new Map<number, Box[]>();

  add(box: Box): void {
    this.each(box, (key) => {
      const cell = this.cells.get(key);
      if (cell === undefined) this.cells.set(key, [box]);
      else cell.push(box);
    });
  }

  /** Whether any box but `own` overlaps this one. */
  isTaken(box: Box, own?: Box): boolean {
    let taken = false;
    this.each(box, (key) => {
      taken ||= (this.cells.get(key) ?? []).some((other) => other !== own && overlaps(box, other));
    });
    return taken;
  }

  private each(box: Box, visit: (key: number) => void): void {
    const [left, right] = [Math.floor(box.left / CELL_PX), Math.floor(box.right / CELL_PX)];
    const [top, bottom] = [Math.floor(box.top / CELL_PX), Math.floor(box.bottom / CELL_PX)];
    for (let x = left; x <= right; x += 1)
      for (let y = top; y <= bottom; y += 1) visit(x * 65_536 + y);
  }
}

function overlaps(a: Box, b: Box): boolean {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}
