import type { Palette } from "./palette";

/** A small picture. Its centre lies at (centre_x_px, centre_y_px); sizes are CSS pixels. */
export interface Sprite {
  readonly picture: HTMLCanvasElement;
  readonly width_px: number;
  readonly height_px: number;
}

const SPRITES_MAX = 4000;

/** Pictures that are drawn once and copied often: in software a copy costs a tenth of drawing text or a path. */
export class Sprites {
  private readonly made = new Map<string, Sprite>();
  private palette: Palette | null = null;
  private pixel_ratio = 0;

  /** Forgets everything when the colours or the screen's pixels have changed. */
  prepare(palette: Palette, pixel_ratio: number): void {
    if (palette === this.palette && pixel_ratio === this.pixel_ratio) return;
    this.made.clear();
    this.palette = palette;
    this.pixel_ratio = pixel_ratio;
  }

  /** `paint` draws around (0, 0), the centre of the picture. */
  get(
    key: string,
    size: () => readonly [width_px: number, height_px: number],
    paint: (context: CanvasRenderingContext2D) => void,
  ): Sprite {
    const known = this.made.get(key);
    if (known !== undefined) return known;
    if (this.made.size >= SPRITES_MAX) this.made.clear();
    const [width_px, height_px] = size();
    const picture = document.createElement("canvas");
    picture.width = Math.ceil(width_px * this.pixel_ratio);
    picture.height = Math.ceil(height_px * this.pixel_ratio);
    const context = picture.getContext("2d")!;
    context.setTransform(
      this.pixel_ratio,
      0,
      0,
      this.pixel_ratio,
      picture.width / 2,
      picture.height / 2,
    );
    paint(context);
    const sprite = {
      picture,
      width_px: picture.width / this.pixel_ratio,
      height_px: picture.height / this.pixel_ratio,
    };
    this.made.set(key, sprite);
    return sprite;
  }

  /** Copies it to whole pixels of the screen, which needs no blending of neighbours. */
  copy(context: CanvasRenderingContext2D, sprite: Sprite, x_px: number, y_px: number): void {
    const whole = (px: number) => Math.round(px * this.pixel_ratio) / this.pixel_ratio;
    context.drawImage(
      sprite.picture,
      whole(x_px - sprite.width_px / 2),
      whole(y_px - sprite.height_px / 2),
      sprite.width_px,
      sprite.height_px,
    );
  }
}
