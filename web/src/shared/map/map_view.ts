import type { CampusShape } from "../campus/campus_geometry";
import { stopName } from "../campus/campus_geometry";
import { conditionOf } from "../scene/condition";
import { Motion } from "../scene/pose_interpolation";
import type { Point, Scene, VehicleScene } from "../scene/scene";
import type { Bounds, Camera, Padding, Size } from "./camera/camera";
import { boundsOf, fitted, toScreen, zoomedAt } from "./camera/camera";
import { Gestures } from "./camera/gestures";
import { Ground, drawLine, useMapMetres } from "./drawing/base_map";
import type { Label } from "./drawing/labels";
import { drawLabels } from "./drawing/labels";
import type { StopRole } from "./drawing/markers";
import {
  bodyLength_px,
  drawStop,
  drawVehicle,
  stopReach_px,
  vehicleReach_px,
} from "./drawing/markers";
import type { Palette } from "./drawing/palette";
import { readPalette } from "./drawing/palette";
import { routeAhead } from "./drawing/route_ahead";

/** Draws something of a page's own; the pen is in map metres. */
export type Layer = (
  pen: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  shape: CampusShape,
) => void;

/** What the page wants the map to show besides the campus itself. */
export interface Look {
  readonly scene: Scene | null;
  readonly pickup: string;
  readonly destination: string;
  readonly chosen_vehicle: string;
  /** Closed road, as lines in the map frame. */
  readonly closed?: readonly (readonly Point[])[];
  readonly language: string;
  /** Shuttles jump from report to report instead of gliding. */
  readonly still: boolean;
  /** Drawn over the routes, in map metres. */
  readonly layer?: Layer;
  /** The camera stays with the chosen shuttle until a person takes it. */
  readonly follow?: boolean;
}

export type Picked =
  { readonly kind: "stop" | "vehicle"; readonly id: string } | { readonly kind: "nothing" };

export interface MapEvents {
  picked(what: Picked): void;
  /** The person has taken the camera: following and fitting should rest. */
  taken(): void;
}

/** Room for marks and labels, and on the right for the buttons. */
const FREE_EDGE: Padding = { top: 32, right: 88, bottom: 40, left: 36 };
const CLOSED_PX = 6;
const FOLLOW_PX_PER_M_MIN = 9;
const FINGERTIP_PX = 24;
const MOUSE_PX = 12;

/** Draws a campus on a canvas. It owns the camera and draws only when something has changed or moves. */
export class MapView {
  private readonly pen: CanvasRenderingContext2D;
  private readonly leaving = new AbortController();
  private readonly watcher: ResizeObserver;
  private readonly motion = new Motion();
  private shape: CampusShape | null = null;
  private ground: Ground | null = null;
  private look: Look | null = null;
  private palette: Palette;
  private frame = 0;
  private size: Size = { width_px: 1, height_px: 1 };
  private camera: Camera = { x_m: 0, y_m: 0, px_per_m: 1 };
  private following = false;
  private wanted: { bounds: Bounds; padding: Padding } | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly events: MapEvents,
  ) {
    const pen = canvas.getContext("2d");
    if (pen === null) throw new Error("this browser cannot draw on a canvas");
    this.pen = pen;
    this.palette = readPalette(canvas);
    this.watcher = new ResizeObserver(() => this.resized());
    this.watcher.observe(canvas);
    const scheme = matchMedia("(prefers-color-scheme: dark)");
    scheme.addEventListener("change", () => this.recoloured(), { signal: this.leaving.signal });
    new Gestures(
      canvas,
      {
        camera: () => this.camera,
        size: () => this.size,
        moved: (camera) => this.take(camera),
        tapped: (x, y, fingertip) => this.events.picked(this.at(x, y, fingertip)),
      },
      this.leaving.signal,
    );
  }

  leave(): void {
    this.leaving.abort();
    this.watcher.disconnect();
    cancelAnimationFrame(this.frame);
  }

  showCampus(shape: CampusShape): void {
    if (shape === this.shape) return;
    this.shape = shape;
    this.ground = new Ground(shape);
    this.soon();
  }

  show(look: Look): void {
    if (look.scene !== null && look.scene !== this.look?.scene)
      this.motion.accept(look.scene, performance.now(), look.still);
    if (look.follow !== this.look?.follow) this.following = look.follow === true;
    this.look = look;
    this.soon();
  }

  /** Shows all of these points, now and after every change of size, until a person takes the camera. */
  fit(points: Iterable<Point>, padding: Padding = FREE_EDGE): void {
    const bounds = boundsOf(points);
    if (bounds === null) return;
    this.wanted = { bounds, padding };
    this.camera = fitted(bounds, this.size, padding);
    this.soon();
  }

  zoom(factor: number): void {
    const { width_px, height_px } = this.size;
    if (this.following) {
      this.camera = zoomedAt(this.camera, this.size, width_px / 2, height_px / 2, factor);
      this.soon();
      return;
    }
    this.take(zoomedAt(this.camera, this.size, width_px / 2, height_px / 2, factor));
  }

  private take(camera: Camera): void {
    this.camera = camera;
    this.wanted = null;
    this.following = false;
    this.events.taken();
    this.soon();
  }

  private resized(): void {
    const box = this.canvas.getBoundingClientRect();
    if (box.width === 0 || box.height === 0) return;
    this.size = { width_px: box.width, height_px: box.height };
    if (this.wanted !== null)
      this.camera = fitted(this.wanted.bounds, this.size, this.wanted.padding);
    this.draw();
  }

  private recoloured(): void {
    this.palette = readPalette(this.canvas);
    this.soon();
  }

  private soon(): void {
    if (this.frame === 0) this.frame = requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    const { pen, palette, size } = this;
    const ratio = this.fillPixels();
    const now_ms = performance.now();
    this.followChosen(now_ms);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.fillStyle = palette.ground;
    pen.fillRect(0, 0, size.width_px, size.height_px);
    pen.save();
    useMapMetres(pen, this.camera, size, ratio);
    this.ground?.draw(pen, this.camera, palette);
    for (const line of this.look?.closed ?? [])
      drawLine(pen, this.camera, line, palette.closed, CLOSED_PX);
    this.drawRoutes(now_ms);
    if (this.shape !== null) this.look?.layer?.(pen, this.camera, palette, this.shape);
    pen.restore();
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const labels = [...this.drawVehicles(now_ms), ...this.drawStops()];
    drawLabels(pen, palette, labels, size);
    if (this.motion.isMoving(now_ms)) this.soon();
  }

  private followChosen(now_ms: number): void {
    if (!this.following) return;
    const vehicle = this.located().find((one) => one.vehicle_id === this.look?.chosen_vehicle);
    if (vehicle === undefined) return;
    const { x_m, y_m } = this.motion.pose(vehicle, now_ms);
    const { px_per_m } = this.camera;
    // From the whole campus it comes near at once; whoever has zoomed since keeps that.
    const nearer = this.wanted === null ? px_per_m : Math.max(px_per_m, FOLLOW_PX_PER_M_MIN);
    this.wanted = null;
    this.camera = { x_m, y_m, px_per_m: nearer };
  }

  /** Matches the canvas to the screen's pixels; returns how many of them make one CSS pixel. */
  private fillPixels(): number {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [
      Math.round(this.size.width_px * ratio),
      Math.round(this.size.height_px * ratio),
    ];
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    return ratio;
  }

  private drawRoutes(now_ms: number): void {
    const chosen = this.look?.chosen_vehicle ?? "";
    for (const vehicle of this.located()) {
      const is_chosen = vehicle.vehicle_id === chosen;
      const { x_m, y_m } = this.motion.pose(vehicle, now_ms);
      const ahead = routeAhead(vehicle.route, x_m, y_m);
      this.pen.globalAlpha = is_chosen ? 0.85 : 0.35;
      drawLine(this.pen, this.camera, ahead, this.palette.route, is_chosen ? 5 : 3);
    }
    this.pen.globalAlpha = 1;
  }

  private drawStops(): Label[] {
    const labels: Label[] = [];
    for (const stop of this.shape?.stops ?? []) {
      const role = this.roleOf(stop.stop_id);
      const [x_px, y_px] = toScreen(this.camera, this.size, stop.x_m, stop.y_m);
      if (!this.onScreen(x_px, y_px)) continue;
      drawStop(this.pen, this.palette, x_px, y_px, role);
      const text = stopName(stop, this.look?.language ?? "en");
      const strong = role !== "plain";
      labels.push({ text, x_px, y_px, reach_px: stopReach_px(role), strong });
    }
    return labels.sort((a, b) => Number(b.strong) - Number(a.strong));
  }

  private drawVehicles(now_ms: number): Label[] {
    const length = bodyLength_px(this.camera.px_per_m);
    return this.located().map((vehicle) => {
      const pose = this.motion.pose(vehicle, now_ms);
      const [x, y] = toScreen(this.camera, this.size, pose.x_m, pose.y_m);
      const chosen = vehicle.vehicle_id === this.look?.chosen_vehicle;
      drawVehicle(this.pen, this.palette, {
        x,
        y,
        heading_rad: pose.yaw_rad,
        length,
        condition: conditionOf(vehicle),
        chosen,
      });
      const reach_px = vehicleReach_px(length, chosen);
      return { text: vehicle.name, x_px: x, y_px: y, reach_px, strong: true };
    });
  }

  private located(): readonly VehicleScene[] {
    return (this.look?.scene?.vehicles ?? []).filter((vehicle) => vehicle.located);
  }

  private roleOf(stop_id: string): StopRole {
    if (stop_id === this.look?.pickup) return "pickup";
    return stop_id === this.look?.destination ? "destination" : "plain";
  }

  private onScreen(x: number, y: number): boolean {
    return x > -20 && y > -20 && x < this.size.width_px + 20 && y < this.size.height_px + 20;
  }

  /** The nearest thing within reach of a fingertip; shuttles before stops. */
  private at(x_px: number, y_px: number, fingertip: boolean): Picked {
    const reach = fingertip ? FINGERTIP_PX : MOUSE_PX;
    const away = (x_m: number, y_m: number) => {
      const [x, y] = toScreen(this.camera, this.size, x_m, y_m);
      return Math.hypot(x - x_px, y - y_px);
    };
    const vehicle = nearest(this.located(), (v) => away(v.x_m, v.y_m), reach);
    if (vehicle !== null) return { kind: "vehicle", id: vehicle.vehicle_id };
    const stop = nearest(this.shape?.stops ?? [], (s) => away(s.x_m, s.y_m), reach);
    return stop === null ? { kind: "nothing" } : { kind: "stop", id: stop.stop_id };
  }
}

function nearest<T>(items: readonly T[], away: (item: T) => number, within: number): T | null {
  let best: T | null = null;
  let best_away = within;
  for (const item of items) {
    const distance = away(item);
    if (distance <= best_away) [best, best_away] = [item, distance];
  }
  return best;
}
