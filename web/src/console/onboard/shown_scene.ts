import { signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import type { OnboardScene } from "../../shared/scene/onboard_scene";
import { RequestedWatch } from "./requested_watch";

type ShownScene = Readonly<Schemas["ShownScene"]>;

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

/** What one shuttle sees, while it shows it. */
export class SceneWatch extends RequestedWatch<ShownScene> {
  constructor(vehicle_id: string, scenes: Scenes = SERVER, now_ms?: () => number) {
    super({ ask: () => scenes.ask(vehicle_id), newest: () => scenes.newest(vehicle_id) }, now_ms);
  }

  /** What may be drawn as the present: nothing that is old. */
  get present(): OnboardScene | null {
    return this.is_present ? (this.shown.value?.scene ?? null) : null;
  }
}

/** What the map of the live page draws, while a shuttle shows it. */
export const live_onboard = signal<SceneWatch | null>(null);
