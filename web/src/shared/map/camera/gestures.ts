import type { Camera, Size } from "./camera";
import { panCamera, zoomCamera } from "./camera";

export interface GestureTarget {
  camera(): Camera;
  size(): Size;
  /** The user moved the camera. */
  cameraMoved(camera: Camera): void;
  tapped(x_px: number, y_px: number, is_touch: boolean): void;
}

interface PointerPosition {
  x: number;
  y: number;
}

const TAP_PX = 8;
const KEY_PAN_PX = 60;
const KEY_ZOOM = 1.4;

/** Pans with one finger, the mouse or arrow keys; zooms with two fingers, the wheel or the keys + and -. Enter taps the centre. */
export class Gestures {
  private readonly pointers = new Map<number, PointerPosition>();
  private travelled_px = 0;
  private pinched = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly target: GestureTarget,
    closing: AbortSignal,
  ) {
    const on = { signal: closing };
    canvas.addEventListener("pointerdown", this.down, on);
    canvas.addEventListener("pointermove", this.move, on);
    canvas.addEventListener("pointerup", this.up, on);
    canvas.addEventListener("pointercancel", this.release, on);
    canvas.addEventListener("wheel", this.wheel, { signal: closing, passive: false });
    canvas.addEventListener("keydown", this.key, on);
  }

  private readonly down = (event: PointerEvent): void => {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, this.at(event));
    if (this.pointers.size === 1) {
      this.travelled_px = 0;
      this.pinched = false;
    } else {
      this.pinched = true;
    }
  };

  private readonly move = (event: PointerEvent): void => {
    const last = this.pointers.get(event.pointerId);
    if (last === undefined) return;
    const now = this.at(event);
    const [dx, dy] = [now.x - last.x, now.y - last.y];
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    this.pointers.set(event.pointerId, now);
    this.travelled_px += Math.hypot(dx, dy);
    if (other !== undefined) this.pinch(last, now, other);
    else if (this.travelled_px > TAP_PX)
      this.target.cameraMoved(panCamera(this.target.camera(), dx, dy));
  };

  private readonly up = (event: PointerEvent): void => {
    const was_tap = this.pointers.size === 1 && !this.pinched && this.travelled_px <= TAP_PX;
    this.release(event);
    if (!was_tap) return;
    const { x, y } = this.at(event);
    this.target.tapped(x, y, event.pointerType !== "mouse");
  };

  private readonly release = (event: PointerEvent): void => {
    this.pointers.delete(event.pointerId);
  };

  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const { x, y } = this.at(event);
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    const factor = Math.exp(-event.deltaY * lines * 0.0016);
    this.target.cameraMoved(zoomCamera(this.target.camera(), this.target.size(), x, y, factor));
  };

  private readonly key = (event: KeyboardEvent): void => {
    if (event.key === "Enter") {
      const { width_px, height_px } = this.target.size();
      this.target.tapped(width_px / 2, height_px / 2, true);
      return;
    }
    const camera = this.target.camera();
    const moved = cameraAfterKey(event.key, camera, this.target.size());
    if (moved === null || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    this.target.cameraMoved(moved);
  };

  private pinch(last: PointerPosition, now: PointerPosition, other: PointerPosition): void {
    const before = Math.hypot(last.x - other.x, last.y - other.y);
    const after = Math.hypot(now.x - other.x, now.y - other.y);
    if (before < 1) return;
    const [x, y] = [(now.x + other.x) / 2, (now.y + other.y) / 2];
    const camera = panCamera(this.target.camera(), (now.x - last.x) / 2, (now.y - last.y) / 2);
    this.target.cameraMoved(zoomCamera(camera, this.target.size(), x, y, after / before));
  }

  private at(event: MouseEvent): PointerPosition {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }
}

export function cameraAfterKey(key: string, camera: Camera, size: Size): Camera | null {
  const [x, y] = [size.width_px / 2, size.height_px / 2];
  switch (key) {
    case "ArrowLeft":
      return panCamera(camera, KEY_PAN_PX, 0);
    case "ArrowRight":
      return panCamera(camera, -KEY_PAN_PX, 0);
    case "ArrowUp":
      return panCamera(camera, 0, KEY_PAN_PX);
    case "ArrowDown":
      return panCamera(camera, 0, -KEY_PAN_PX);
    case "+":
    case "=":
      return zoomCamera(camera, size, x, y, KEY_ZOOM);
    case "-":
      return zoomCamera(camera, size, x, y, 1 / KEY_ZOOM);
    default:
      return null;
  }
}
