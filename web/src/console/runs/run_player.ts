import { computed, signal } from "@preact/signals";
import { answerOf, api } from "../../shared/api/client";
import type { Answer, Problem } from "../../shared/api/problem";
import type { CampusShape } from "../../shared/campus/campus_geometry";
import { campusShape } from "../../shared/campus/campus_geometry";
import type { Scene } from "../../shared/scene/scene";
import { playedTo, sceneAt } from "./playback";

const CHUNK = 3000;
const STEP_MS = 200;

/** A recorded run as a source of scenes: the same shape as live, with a time that one can set. */
export class Player {
  readonly scenes = signal<readonly Scene[]>([]);
  readonly loading = signal(true);
  readonly problem = signal<Problem | null>(null);
  readonly at_ms = signal(0);
  readonly playing = signal(false);
  readonly factor = signal(1);
  /** The last change of time was a jump: nothing should glide there. */
  readonly jumped = signal(true);
  /** The map that the run was driven on; null until it is here, or when it cannot be had. */
  readonly shape = signal<CampusShape | null>(null);
  readonly map_problem = signal<Problem | null>(null);
  readonly scene = computed(() => sceneAt(this.scenes.value, this.at_ms.value));

  private frame = 0;
  private shown_ms = 0;
  private left = false;

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

  leave(): void {
    this.left = true;
    cancelAnimationFrame(this.frame);
  }

  seek(at_ms: number): void {
    this.jumped.value = true;
    this.at_ms.value = at_ms;
  }

  toggle(): void {
    if (this.playing.value) {
      this.playing.value = false;
      return;
    }
    if (this.at_ms.value >= this.end_ms) this.seek(this.start_ms);
    this.playing.value = true;
    this.shown_ms = performance.now();
    this.frame = requestAnimationFrame((now_ms) => this.step(now_ms));
  }

  private step(now_ms: number): void {
    if (this.left || !this.playing.value) return;
    const elapsed_ms = Math.max(0, now_ms - this.shown_ms);
    this.shown_ms = now_ms;
    const next = playedTo(this.at_ms.value, elapsed_ms, this.factor.value, this.end_ms);
    this.jumped.value = false;
    this.at_ms.value = next.at_ms;
    if (next.ended && !this.loading.value) this.playing.value = false;
    this.frame = requestAnimationFrame((later_ms) => this.step(later_ms));
  }

  private async loadMap(): Promise<void> {
    const path = { vehicle_id: this.vehicle_id, boot_id: this.boot_id };
    const answer = await answerOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/map", { params: { path } }),
    );
    if (answer.ok) this.shape.value = campusShape(answer.value);
    else this.map_problem.value = answer.problem;
  }

  /** Long runs come in pieces; what is here can be played already. */
  private async load(): Promise<void> {
    for (let from_ms = 0, more = true; more && !this.left;) {
      const answer = await this.ask(from_ms);
      if (!answer.ok) {
        this.problem.value = answer.problem;
        break;
      }
      const first = this.scenes.value.length === 0;
      this.scenes.value = [...this.scenes.value, ...answer.value];
      if (first) this.at_ms.value = this.start_ms;
      from_ms = this.end_ms + 1;
      more = answer.value.length === CHUNK;
    }
    this.loading.value = false;
  }

  private ask(from_ms: number): Promise<Answer<Scene[]>> {
    return answerOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/scenes", {
        params: {
          path: { vehicle_id: this.vehicle_id, boot_id: this.boot_id },
          query: { from_ms, step_ms: STEP_MS, limit: CHUNK },
        },
      }),
    ) as Promise<Answer<Scene[]>>;
  }
}
