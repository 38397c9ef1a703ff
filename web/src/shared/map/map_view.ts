import type { CampusGeometry } from "../campus/campus_geometry";
import { stopName } from "../campus/campus_geometry";
import type { Condition } from "../scene/condition";
import { conditionOf, urgencyOf } from "../scene/condition";
import { PoseInterpolator } from "../scene/pose_interpolation";
import { poseOf, type Point, type Scene, type VehicleScene } from "../scene/scene";
import type { Bounds, Camera, Padding, Size } from "./camera/camera";
import { boundsOf, fitCamera, toMap, toScreen, zoomCamera } from "./camera/camera";
import { Gestures } from "./camera/gestures";
import { BaseLayer } from "./drawing/base_layer";
import { drawLine, setMapTransform } from "./drawing/base_map";
import type { Label } from "./drawing/labels";
import { drawLabels } from "./drawing/labels";
import type { StopRole } from "./drawing/markers";
import {
  bodyLength_px,
  drawStop,
  drawVehicle,
  drawVehicleSprite,
  stopRadius_px,
  vehicleRadius_px,
} from "./drawing/markers";
import type { Palette } from "./drawing/palette";
import { readPalette } from "./drawing/palette";
import { routeAhead } from "./drawing/route_ahead";
import { Sprites } from "./drawing/sprites";
import type { MapContent, MapEvents, MapSelection } from "./map_content";

/** Space for markers and labels, and on the right for the buttons. */
const FIT_PADDING: Padding = { top: 32, right: 88, bottom: 40, left: 36 };
const CLOSED_ROAD_PX = 6;
const FOLLOW_PX_PER_M_MIN = 9;
const TOUCH_RADIUS_PX = 24;
const MOUSE_RADIUS_PX = 12;
/** With more shuttles than this, only the selected one's route is drawn: the others would cover the map. */
const ROUTES_MAX = 60;

/** Draws a campus on a canvas. It owns the camera, and draws only when something changed or moves. */
export class MapView {
  private readonly context: CanvasRenderingContext2D;
  private readonly closing = new AbortController();
  private readonly resize_observer: ResizeObserver;
  private readonly poses = new PoseInterpolator();
  private geometry: CampusGeometry | null = null;
  private readonly sprites = new Sprites();
  private base_layer: BaseLayer | null = null;
  private content: MapContent | null = null;
  private palette: Palette;
  private frame = 0;
  private size: Size = { width_px: 1, height_px: 1 };
  private camera: Camera = { x_m: 0, y_m: 0, px_per_m: 1 };
  private following = false;
  private fit_target: { bounds: Bounds; padding: Padding } | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly events: MapEvents,
  ) {
    const context = canvas.getContext("2d");
    if (context === null) throw new Error("this browser cannot draw on a canvas");
    this.context = context;
    this.palette = readPalette(canvas);
    this.resize_observer = new ResizeObserver(() => this.resized());
    this.resize_observer.observe(canvas);
    const scheme = matchMedia("(prefers-color-scheme: dark)");
    scheme.addEventListener("change", () => this.paletteChanged(), { signal: this.closing.signal });
    new Gestures(
      canvas,
      {
        camera: () => this.camera,
        size: () => this.size,
        cameraMoved: (camera) => this.moveCamera(camera),
        tapped: (x, y, is_touch) => this.events.selected(this.selectionAt(x, y, is_touch)),
        grabbed: (x, y, is_touch) =>
          this.events.drag()?.grab(toMap(this.camera, this.size, x, y), this.reach_m(is_touch)) ??
          false,
        dragged: (x, y) => this.events.drag()?.drag(toMap(this.camera, this.size, x, y)),
        dropped: () => this.events.drag()?.drop(),
        letGo: () => this.events.drag()?.letGo(),
      },
      this.closing.signal,
    );
  }

  close(): void {
    this.closing.abort();
    this.resize_observer.disconnect();
    cancelAnimationFrame(this.frame);
  }

  setGeometry(geometry: CampusGeometry): void {
    if (geometry === this.geometry) return;
    this.geometry = geometry;
    this.base_layer = new BaseLayer(geometry);
    this.requestFrame();
  }

  setContent(content: MapContent): void {
    const before = this.content;
    const has_moved =
      content.scene !== null &&
      content.scene !== before?.scene &&
      this.poses.update(content.scene, performance.now(), content.interpolate);
    if (content.follow !== before?.follow) this.following = content.follow === true;
    this.content = content;
    if (has_moved || before === null || isDrawnDifferently(before, content)) this.requestFrame();
  }

  /** Shows all of these points, now and after every change of size, until the user moves the camera. */
  fit(points: Iterable<Point>, padding: Padding = FIT_PADDING): void {
    const bounds = boundsOf(points);
    if (bounds === null) return;
    this.fit_target = { bounds, padding };
    this.camera = fitCamera(bounds, this.size, padding);
    this.requestFrame();
  }

  zoom(factor: number): void {
    const { width_px, height_px } = this.size;
    const camera = zoomCamera(this.camera, this.size, width_px / 2, height_px / 2, factor);
    if (!this.following) {
      this.moveCamera(camera);
      return;
    }
    this.camera = camera;
    this.requestFrame();
  }

  private moveCamera(camera: Camera): void {
    this.camera = camera;
    this.fit_target = null;
    this.following = false;
    this.events.cameraMoved();
    this.requestFrame();
  }

  private resized(): void {
    const box = this.canvas.getBoundingClientRect();
    if (box.width === 0 || box.height === 0) return;
    this.size = { width_px: box.width, height_px: box.height };
    if (this.fit_target !== null)
      this.camera = fitCamera(this.fit_target.bounds, this.size, this.fit_target.padding);
    this.draw();
  }

  private paletteChanged(): void {
    this.palette = readPalette(this.canvas);
    this.requestFrame();
  }

  private requestFrame(): void {
    if (this.frame === 0) this.frame = requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    const { context, palette, size } = this;
    const pixel_ratio = this.resizeCanvas();
    const now_ms = performance.now();
    this.followSelected(now_ms);
    context.setTransform(pixel_ratio, 0, 0, pixel_ratio, 0, 0);
    this.sprites.prepare(palette, pixel_ratio);
    if (this.base_layer === null) {
      context.fillStyle = palette.ground;
      context.fillRect(0, 0, size.width_px, size.height_px);
    } else this.base_layer.draw(context, this.camera, size, palette, pixel_ratio);
    context.save();
    setMapTransform(context, this.camera, size, pixel_ratio);
    for (const line of this.content?.closed_roads ?? [])
      drawLine(context, this.camera, line, palette.closed_road, CLOSED_ROAD_PX);
    this.drawRoutes(now_ms);
    if (this.geometry !== null) this.content?.layer?.(context, this.camera, palette, this.geometry);
    context.restore();
    context.setTransform(pixel_ratio, 0, 0, pixel_ratio, 0, 0);
    const vehicles = this.drawVehicles(now_ms);
    const stops = this.drawStops();
    // In a large fleet, the names of stops come before those of shuttles on which all is well.
    const [first, later] = vehicles.length > ROUTES_MAX ? byUrgency(vehicles) : [vehicles, []];
    drawLabels(context, palette, this.sprites, [...first, ...stops, ...later], size);
    if (this.poses.isMoving(now_ms)) this.requestFrame();
  }

  private followSelected(now_ms: number): void {
    if (!this.following) return;
    const vehicle = this.located().find((vehicle) => this.isSelected(vehicle));
    if (vehicle === undefined) return;
    const pose = this.poses.pose(vehicle, now_ms);
    if (pose === null) return;
    let { px_per_m } = this.camera;
    // A camera that shows the whole campus zooms in at once; a zoom that the user chose stays.
    if (this.fit_target !== null) px_per_m = Math.max(px_per_m, FOLLOW_PX_PER_M_MIN);
    this.fit_target = null;
    this.camera = { x_m: pose.x_m, y_m: pose.y_m, px_per_m };
  }

  /** Matches the canvas to the screen's pixels; returns the number of screen pixels per CSS pixel. */
  private resizeCanvas(): number {
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
    const located = this.located();
    for (const vehicle of located) {
      const selected = this.isSelected(vehicle);
      if (!selected && located.length > ROUTES_MAX) continue;
      const pose = this.poses.pose(vehicle, now_ms);
      if (pose === null) continue;
      const ahead = routeAhead(vehicle.task.route, pose.x_m, pose.y_m);
      this.context.globalAlpha = selected ? 0.85 : 0.35;
      drawLine(this.context, this.camera, ahead, this.palette.route, selected ? 5 : 3);
    }
    this.context.globalAlpha = 1;
  }

  private drawStops(): Label[] {
    const labels: Label[] = [];
    for (const stop of this.geometry?.stops ?? []) {
      const role = this.roleOf(stop.stop_id);
      const [x_px, y_px] = toScreen(this.camera, this.size, stop.x_m, stop.y_m);
      if (!this.onScreen(x_px, y_px)) continue;
      drawStop(this.context, this.palette, x_px, y_px, role);
      const text = stopName(stop, this.content?.language ?? "en");
      const strong = role !== "plain";
      labels.push({ text, x_px, y_px, radius_px: stopRadius_px(role), strong });
    }
    return labels.sort((a, b) => Number(b.strong) - Number(a.strong));
  }

  private drawVehicles(now_ms: number): VehicleLabel[] {
    const length = bodyLength_px(this.camera.px_per_m);
    const located = this.located();
    const many = located.length > ROUTES_MAX;
    return located.flatMap((vehicle) => {
      const pose = this.poses.pose(vehicle, now_ms);
      if (pose === null) return [];
      const [x, y] = toScreen(this.camera, this.size, pose.x_m, pose.y_m);
      if (!this.onScreen(x, y)) return [];
      const selected = this.isSelected(vehicle);
      const condition = conditionOf(vehicle);
      const marker = { x, y, heading_rad: pose.yaw_rad, length, condition, selected };
      if (many) drawVehicleSprite(this.context, this.palette, this.sprites, marker);
      else drawVehicle(this.context, this.palette, marker);
      const radius_px = vehicleRadius_px(length, selected);
      const label = { text: vehicle.facts.name, x_px: x, y_px: y, radius_px, strong: true };
      return [{ ...label, condition, selected }];
    });
  }

  private located(): readonly VehicleScene[] {
    return (this.content?.scene?.vehicles ?? []).filter((vehicle) => vehicle.status !== null);
  }

  private isSelected(vehicle: VehicleScene): boolean {
    return vehicle.vehicle_id === this.content?.selected_vehicle;
  }

  private roleOf(stop_id: string): StopRole {
    if (stop_id === this.content?.pickup) return "pickup";
    return stop_id === this.content?.destination ? "destination" : "plain";
  }

  private onScreen(x: number, y: number): boolean {
    return x > -20 && y > -20 && x < this.size.width_px + 20 && y < this.size.height_px + 20;
  }

  /** The nearest shuttle, or else the nearest stop, or else the ground, within the radius of a finger or a mouse. */
  private reach_m(is_touch: boolean): number {
    return (is_touch ? TOUCH_RADIUS_PX : MOUSE_RADIUS_PX) / this.camera.px_per_m;
  }

  private selectionAt(x_px: number, y_px: number, is_touch: boolean): MapSelection {
    const radius_px = is_touch ? TOUCH_RADIUS_PX : MOUSE_RADIUS_PX;
    const ground: MapSelection = {
      kind: "ground",
      at: toMap(this.camera, this.size, x_px, y_px),
      reach_m: this.reach_m(is_touch),
    };
    if (this.content?.selects_ground === true) return ground;
    const distance_px = (x_m: number, y_m: number) => {
      const [x, y] = toScreen(this.camera, this.size, x_m, y_m);
      return Math.hypot(x - x_px, y - y_px);
    };
    const distanceOfVehicle_px = (vehicle: VehicleScene) => {
      const pose = poseOf(vehicle);
      return pose === null ? Infinity : distance_px(pose.x_m, pose.y_m);
    };
    const vehicle = nearest(this.located(), distanceOfVehicle_px, radius_px);
    if (vehicle !== null) return { kind: "vehicle", id: vehicle.vehicle_id };
    const stop = nearest(this.geometry?.stops ?? [], (s) => distance_px(s.x_m, s.y_m), radius_px);
    return stop === null ? ground : { kind: "stop", id: stop.stop_id };
  }
}

type VehicleLabel = Label & { readonly condition: Condition; readonly selected: boolean };

/** The labels of shuttles that need attention, and the others. */
function byUrgency(labels: readonly VehicleLabel[]): readonly [VehicleLabel[], VehicleLabel[]] {
  const rank = ({ selected, condition }: VehicleLabel) =>
    selected ? 0 : urgencyOf(condition) === "danger" ? 1 : 2;
  const urgent = labels.filter((label) => rank(label) < 2).sort((a, b) => rank(a) - rank(b));
  return [urgent, labels.filter((label) => rank(label) === 2)];
}

/** Whether the map looks different for any reason but the places of the shuttles. */
function isDrawnDifferently(before: MapContent, after: MapContent): boolean {
  if (after.layer !== undefined || before.layer !== undefined) return true;
  const names = ["pickup", "destination", "selected_vehicle", "language", "follow"] as const;
  if (names.some((name) => before[name] !== after[name])) return true;
  if (before.closed_roads !== after.closed_roads) return true;
  return looksOf(before.scene) !== looksOf(after.scene);
}

/** What is drawn of the shuttles besides their places. */
function looksOf(scene: Scene | null): string {
  return (scene?.vehicles ?? [])
    .map((vehicle) => {
      const { facts, task } = vehicle;
      const end = task.route.at(-1) ?? [];
      return [facts.name, conditionOf(vehicle), task.route.length, ...end].join(" ");
    })
    .join("|");
}

function nearest<T>(items: readonly T[], distanceOf: (item: T) => number, max: number): T | null {
  let best: T | null = null;
  let best_distance = max;
  for (const item of items) {
    const distance = distanceOf(item);
    if (distance <= best_distance) [best, best_distance] = [item, distance];
  }
  return best;
}
