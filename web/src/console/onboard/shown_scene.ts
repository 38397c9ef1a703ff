import { signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import type { OnboardScene } from "../../shared/scene/onboard_scene";

type ShownScene = Readonly<Schemas["ShownScene"]>;

/** A new scene comes every 400 ms. */
const EVERY_MS = 400;
/** The shuttle shows it for so long after each request, and the page looks a little longer. */
export const SHOWN_MS = 60_000;
/** From this age on what is shown is told as old. */
export const OLD_MS = 2_000;

export interface Scenes {
  ask(vehicle_id: string): Promise<Result<unknown>>;
  newest(vehicle_id: string): Promise<Result<ShownScene>>;
}

const SERVER: Scenes = {
  ask: (vehicle_id) =>
    resultOf(api.POST("/api/v1/vehicles/{vehicle_id}/scene", { params: { path: { vehicle_id } } })),
  newest: (vehicle_id) =>
    resultOf(
      api.GET("/api/v1/vehicles/{vehicle_id}/scene", { params: { path: { vehicle_id } } }),
    ) as Promise<Result<ShownScene>>,
};

/** What one shuttle shows on request: asks for it, and looks for new scenes until the minute is over. */
export class SceneWatch {
  /** What came last; null before the first answer. */
  readonly shown = signal<ShownScene | null>(null);
  readonly problem = signal<Problem | null>(null);
  /** Whether new scenes are looked for. */
  readonly watching = signal(false);
  private until_ms = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private answered_ms = 0;

  constructor(
    private readonly vehicle_id: string,
    private readonly scenes: Scenes = SERVER,
    private readonly now_ms: () => number = () => performance.now(),
  ) {}

  async ask(): Promise<void> {
    const result = await this.scenes.ask(this.vehicle_id);
    this.problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    this.until_ms = this.now_ms() + SHOWN_MS;
    if (this.watching.value) return;
    this.watching.value = true;
    void this.look();
  }

  close(): void {
    clearTimeout(this.timer);
    this.watching.value = false;
  }

  /** How old the newest scene is by the server's clock and the time since its answer; null without one. */
  get age_ms(): number | null {
    const { value: shown } = this.shown;
    if (shown === null || shown.received_ms === 0) return null;
    return shown.now_ms - shown.received_ms + Math.max(this.now_ms() - this.answered_ms, 0);
  }

  /** What may be drawn as the present: nothing that is old. */
  get present(): OnboardScene | null {
    const { age_ms } = this;
    return age_ms === null || age_ms > OLD_MS ? null : (this.shown.value?.scene ?? null);
  }

  private async look(): Promise<void> {
    const result = await this.scenes.newest(this.vehicle_id);
    if (!this.watching.value) return;
    this.problem.value = result.ok ? null : result.problem;
    if (result.ok) {
      this.shown.value = result.value;
      this.answered_ms = this.now_ms();
    }
    if (this.now_ms() >= this.until_ms) this.watching.value = false;
    else this.timer = setTimeout(() => void this.look(), EVERY_MS);
  }
}

/** What the map of the live page draws, while a shuttle shows it. */
export const live_onboard = signal<SceneWatch | null>(null);
