import { computed, signal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import type { CampusGeometry } from "../../shared/campus/campus_geometry";
import { campusGeometry } from "../../shared/campus/campus_geometry";
import type { Scene } from "../../shared/scene/scene";
import { advancePlayback, sceneAt } from "./playback";

const SCENES_PER_REQUEST = 3000;
const STEP_MS = 200;

/** A recorded run as a source of scenes, as live ones are, with a time that the operator sets. */
export class RunPlayer {
  readonly scenes = signal<readonly Scene[]>([]);
  readonly loading = signal(true);
  readonly problem = signal<Problem | null>(null);
  readonly at_ms = signal(0);
  readonly playing = signal(false);
  readonly speed_factor = signal(1);
  /** The last change of time was a seek, across which poses are not interpolated. */
  readonly is_seek = signal(true);
  /** The map of the recording; null before it is loaded, or if it is missing. */
  readonly geometry = signal<CampusGeometry | null>(null);
  readonly map_problem = signal<Problem | null>(null);
  readonly scene = computed(() => sceneAt(this.scenes.value, this.at_ms.value));

  private frame = 0;
  private last_frame_ms = 0;
  private closed = false;

  constructor(
    private readonly vehicle_id: string,
    private readonly boot_id: string,
  ) {
    void this.loadMap();
    void this.load();
  }

  get start_ms(): number {
    return this.scenes.value[0]?.at_ms ?? 0;
  }

  get end_ms(): number {
    return this.scenes.value.at(-1)?.at_ms ?? 0;
  }

  close(): void {
    this.closed = true;
    cancelAnimationFrame(this.frame);
  }

  seek(at_ms: number): void {
    this.is_seek.value = true;
    this.at_ms.value = at_ms;
  }

  toggle(): void {
    if (this.playing.value) {
      this.playing.value = false;
      return;
    }
    if (this.at_ms.value >= this.end_ms) this.seek(this.start_ms);
    this.playing.value = true;
    this.last_frame_ms = performance.now();
    this.frame = requestAnimationFrame((now_ms) => this.step(now_ms));
  }

  private step(now_ms: number): void {
    if (this.closed || !this.playing.value) return;
    const elapsed_ms = Math.max(0, now_ms - this.last_frame_ms);
    this.last_frame_ms = now_ms;
    const next = advancePlayback(
      this.at_ms.value,
      elapsed_ms,
      this.speed_factor.value,
      this.end_ms,
    );
    this.is_seek.value = false;
    this.at_ms.value = next.at_ms;
    if (next.ended && !this.loading.value) this.playing.value = false;
    this.frame = requestAnimationFrame((later_ms) => this.step(later_ms));
  }

  private async loadMap(): Promise<void> {
    const path = { vehicle_id: this.vehicle_id, boot_id: this.boot_id };
    const result = await resultOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/map", { params: { path } }),
    );
    if (result.ok) this.geometry.value = campusGeometry(result.value);
    else this.map_problem.value = result.problem;
  }

  /** Loads the scenes in several requests; what is loaded can be played at once. */
  private async load(): Promise<void> {
    for (let from_ms = 0, more = true; more && !this.closed;) {
      const result = await this.requestScenes(from_ms);
      if (!result.ok) {
        this.problem.value = result.problem;
        break;
      }
      const is_first = this.scenes.value.length === 0;
      this.scenes.value = [...this.scenes.value, ...result.value];
      if (is_first) this.at_ms.value = this.start_ms;
      from_ms = this.end_ms + 1;
      more = result.value.length === SCENES_PER_REQUEST;
    }
    this.loading.value = false;
  }

  private requestScenes(from_ms: number): Promise<Result<Scene[]>> {
    return resultOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/scenes", {
        params: {
          path: { vehicle_id: this.vehicle_id, boot_id: this.boot_id },
          query: { from_ms, step_ms: STEP_MS, limit: SCENES_PER_REQUEST },
        },
      }),
    ) as Promise<Result<Scene[]>>;
  }
}
