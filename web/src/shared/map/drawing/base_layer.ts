import type { CampusGeometry } from "../../campus/campus_geometry";
import type { Camera, Size } from "../camera/camera";
import { BaseMap, setMapTransform } from "./base_map";
import type { Palette } from "./palette";

/** Ground, roads and buildings as one picture, drawn again only when the camera, the size or the colours change. */
export class BaseLayer {
  private readonly picture = document.createElement("canvas");
  private readonly context = this.picture.getContext("2d", { alpha: false })!;
  private readonly map: BaseMap;
  private drawn = "";
  private palette: Palette | null = null;

  constructor(readonly geometry: CampusGeometry) {
    this.map = new BaseMap(geometry);
  }

  /** Covers the whole canvas. The context's transform must count in CSS pixels. */
  draw(
    context: CanvasRenderingContext2D,
    camera: Camera,
    size: Size,
    palette: Palette,
    pixel_ratio: number,
  ): void {
    const { width, height } = context.canvas;
    const wanted = [camera.x_m, camera.y_m, camera.px_per_m, width, height, pixel_ratio].join(" ");
    if (wanted !== this.drawn || palette !== this.palette) {
      this.picture.width = width;
      this.picture.height = height;
      this.paint(camera, size, palette, pixel_ratio);
      this.drawn = wanted;
      this.palette = palette;
    }
    context.drawImage(this.picture, 0, 0, size.width_px, size.height_px);
  }

  private paint(camera: Camera, size: Size, palette: Palette, pixel_ratio: number): void {
    this.context.setTransform(1, 0, 0, 1, 0, 0);
    this.context.fillStyle = palette.ground;
    this.context.fillRect(0, 0, this.picture.width, this.picture.height);
    setMapTransform(this.context, camera, size, pixel_ratio);
    this.map.draw(this.context, camera, palette);
  }
}
