import { signal } from "@preact/signals";
import { advancePlayback } from "./playback";

/** The factors by which a replay can be slower or faster than it was. */
export const SPEED_FACTORS: readonly number[] = [0.25, 0.5, 1, 2, 5, 10, 30, 100];

/** The time of a replay: the operator sets it, or it runs. */
export class PlaybackClock {
  readonly at_ms = signal(0);
  readonly playing = signal(false);
  readonly speed_factor = signal(1);
  /** The last change of time was a seek, across which poses are not interpolated. */
  readonly is_seek = signal(true);

  private frame = 0;
  private last_frame_ms = 0;

  /** span: from when to when there is something, and whether more will come. May change while time runs. */
  constructor(
    private readonly span: () => {
      readonly start_ms: number;
      readonly end_ms: number;
      readonly grows: boolean;
    },
  ) {}

  seek(at_ms: number): void {
    const { start_ms, end_ms } = this.span();
    this.is_seek.value = true;
    this.at_ms.value = Math.min(Math.max(at_ms, start_ms), end_ms);
  }

  toggle(): void {
    if (this.playing.value) {
      this.playing.value = false;
      return;
    }
    const { start_ms, end_ms } = this.span();
    if (this.at_ms.value >= end_ms) this.seek(start_ms);
    this.playing.value = true;
    this.last_frame_ms = performance.now();
    this.frame = requestAnimationFrame((now_ms) => this.step(now_ms));
  }

  close(): void {
    this.playing.value = false;
    cancelAnimationFrame(this.frame);
  }

  private step(now_ms: number): void {
    if (!this.playing.value) return;
    const elapsed_ms = Math.max(0, now_ms - this.last_frame_ms);
    this.last_frame_ms = now_ms;
    const { end_ms, grows } = this.span();
    const next = advancePlayback(this.at_ms.value, elapsed_ms, this.speed_factor.value, end_ms);
    this.is_seek.value = false;
    this.at_ms.value = next.at_ms;
    if (next.ended && !grows) this.playing.value = false;
    this.frame = requestAnimationFrame((later_ms) => this.step(later_ms));
  }
}
