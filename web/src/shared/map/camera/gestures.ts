import type { Camera, Size } from "./camera";
import { panCamera, zoomCamera } from "./camera";

export interface GestureTarget {
  camera(): Camera;
  size(): Size;
  /** The user moved the camera. */
  cameraMoved(camera: Camera): void;
  tapped(x_px: number, y_px: number, is_touch: boolean): void;
  /** Whether something is taken hold of there; if so, one finger or the mouse drags it and not the map. */
  grabbed(x_px: number, y_px: number, is_touch: boolean): boolean;
  dragged(x_px: number, y_px: number): void;
  /** It is put down where it was dragged to last. */
  dropped(): void;
  /** It goes back to where it was: a second finger came, or the browser took the gesture for itself. */
  letGo(): void;
}

interface PointerPosition {
  x: number;
  y: number;
}

const TAP_PX = 8;
const KEY_PAN_PX = 60;
const KEY_ZOOM = 1.4;

/** Pans or drags with one finger or the mouse, and pans with arrow keys; zooms with two fingers, the wheel or the keys + and -. Enter taps the centre. */
export class Gestures {
  private readonly pointers = new Map<number, PointerPosition>();
  private travelled_px = 0;
  private pinched = false;
  private holding = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly target: GestureTarget,
    closing: AbortSignal,
  ) {
    const on = { signal: closing };
    canvas.addEventListener("pointerdown", this.down, on);
    canvas.addEventListener("pointermove", this.move, on);
    canvas.addEventListener("pointerup", this.up, on);
    canvas.addEventListener("pointercancel", this.cancel, on);
    canvas.addEventListener("wheel", this.wheel, { signal: closing, passive: false });
    canvas.addEventListener("keydown", this.key, on);
  }

  private readonly down = (event: PointerEvent): void => {
    this.canvas.setPointerCapture(event.pointerId);
    const { x, y } = this.at(event);
    this.pointers.set(event.pointerId, { x, y });
    if (this.pointers.size === 1) {
      this.travelled_px = 0;
      this.pinched = false;
      this.holding = event.button === 0 && this.target.grabbed(x, y, event.pointerType !== "mouse");
    } else {
      this.pinched = true;
      this.letGo();
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
    else if (this.travelled_px <= TAP_PX) return;
    else if (this.holding) this.target.dragged(now.x, now.y);
    else this.target.cameraMoved(panCamera(this.target.camera(), dx, dy));
  };

  private readonly up = (event: PointerEvent): void => {
    const was_single = this.pointers.size === 1 && !this.pinched;
    const was_tap = was_single && this.travelled_px <= TAP_PX;
    this.pointers.delete(event.pointerId);
    if (this.holding && !was_tap) {
      this.holding = false;
      this.target.dropped();
    }
    if (!was_tap) return;
    this.letGo();
    const { x, y } = this.at(event);
    this.target.tapped(x, y, event.pointerType !== "mouse");
  };

  private readonly cancel = (event: PointerEvent): void => {
    this.pointers.delete(event.pointerId);
    this.letGo();
  };

  private letGo(): void {
    if (!this.holding) return;
    this.holding = false;
    this.target.letGo();
  }

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
