import type { Camera, Size } from "./camera";
import { panned, zoomedAt } from "./camera";

export interface Viewfinder {
  camera(): Camera;
  size(): Size;
  /** The person moved the map. */
  moved(camera: Camera): void;
  tapped(x_px: number, y_px: number, fingertip: boolean): void;
}

interface Finger {
  x: number;
  y: number;
}

const TAP_PX = 8;
const KEY_PAN_PX = 60;
const KEY_ZOOM = 1.4;

/** One finger or the mouse pans, two fingers pinch, the wheel and the keys + - and arrows do the same. */
export class Gestures {
  private readonly fingers = new Map<number, Finger>();
  private travelled_px = 0;
  private pinched = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly finder: Viewfinder,
    leaving: AbortSignal,
  ) {
    const on = { signal: leaving };
    canvas.addEventListener("pointerdown", this.down, on);
    canvas.addEventListener("pointermove", this.move, on);
    canvas.addEventListener("pointerup", this.up, on);
    canvas.addEventListener("pointercancel", this.lost, on);
    canvas.addEventListener("wheel", this.wheel, { signal: leaving, passive: false });
    canvas.addEventListener("keydown", this.key, on);
  }

  private readonly down = (event: PointerEvent): void => {
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, this.at(event));
    if (this.fingers.size === 1) {
      this.travelled_px = 0;
      this.pinched = false;
    } else {
      this.pinched = true;
    }
  };

  private readonly move = (event: PointerEvent): void => {
    const finger = this.fingers.get(event.pointerId);
    if (finger === undefined) return;
    const now = this.at(event);
    const [dx, dy] = [now.x - finger.x, now.y - finger.y];
    const other = [...this.fingers].find(([id]) => id !== event.pointerId)?.[1];
    this.fingers.set(event.pointerId, now);
    this.travelled_px += Math.hypot(dx, dy);
    if (other !== undefined) this.pinch(finger, now, other);
    else if (this.travelled_px > TAP_PX) this.finder.moved(panned(this.finder.camera(), dx, dy));
  };

  private readonly up = (event: PointerEvent): void => {
    const was_tap = this.fingers.size === 1 && !this.pinched && this.travelled_px <= TAP_PX;
    this.lost(event);
    if (!was_tap) return;
    const { x, y } = this.at(event);
    this.finder.tapped(x, y, event.pointerType !== "mouse");
  };

  private readonly lost = (event: PointerEvent): void => {
    this.fingers.delete(event.pointerId);
  };

  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const { x, y } = this.at(event);
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    const factor = Math.exp(-event.deltaY * lines * 0.0016);
    this.finder.moved(zoomedAt(this.finder.camera(), this.finder.size(), x, y, factor));
  };

  private readonly key = (event: KeyboardEvent): void => {
    const camera = this.finder.camera();
    const moved = cameraAfterKey(event.key, camera, this.finder.size());
    if (moved === null || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    this.finder.moved(moved);
  };

  private pinch(was: Finger, now: Finger, other: Finger): void {
    const before = Math.hypot(was.x - other.x, was.y - other.y);
    const after = Math.hypot(now.x - other.x, now.y - other.y);
    if (before < 1) return;
    const [x, y] = [(now.x + other.x) / 2, (now.y + other.y) / 2];
    const camera = panned(this.finder.camera(), (now.x - was.x) / 2, (now.y - was.y) / 2);
    this.finder.moved(zoomedAt(camera, this.finder.size(), x, y, after / before));
  }

  private at(event: MouseEvent): Finger {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }
}

export function cameraAfterKey(key: string, camera: Camera, size: Size): Camera | null {
  const [x, y] = [size.width_px / 2, size.height_px / 2];
  switch (key) {
    case "ArrowLeft":
      return panned(camera, KEY_PAN_PX, 0);
    case "ArrowRight":
      return panned(camera, -KEY_PAN_PX, 0);
    case "ArrowUp":
      return panned(camera, 0, KEY_PAN_PX);
    case "ArrowDown":
      return panned(camera, 0, -KEY_PAN_PX);
    case "+":
    case "=":
      return zoomedAt(camera, size, x, y, KEY_ZOOM);
    case "-":
      return zoomedAt(camera, size, x, y, 1 / KEY_ZOOM);
    default:
      return null;
  }
}
