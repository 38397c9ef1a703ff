import { signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import { RequestedWatch } from "./requested_watch";

type ShownCamera = Readonly<Schemas["ShownCamera"]>;
export type CameraPicture = NonNullable<ShownCamera["picture"]>;

export interface Cameras {
  ask(vehicle_id: string, camera: string): Promise<Result<unknown>>;
  newest(vehicle_id: string, camera: string): Promise<Result<ShownCamera>>;
}

const SERVER: Cameras = {
  ask: (vehicle_id, camera) =>
    resultOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/camera", {
        params: { path: { vehicle_id } },
        body: { camera },
      }),
    ),
  newest: (vehicle_id, camera) =>
    resultOf(
      api.GET("/api/v1/vehicles/{vehicle_id}/camera", {
        params: { path: { vehicle_id }, query: { camera } },
      }),
    ) as Promise<Result<ShownCamera>>,
};

/** What one camera of a shuttle sees, while it shows it. */
export class CameraWatch extends RequestedWatch<ShownCamera> {
  /** "" until the shuttle has named its cameras: then it shows the first one. */
  readonly camera;

  constructor(vehicle_id: string, cameras: Cameras = SERVER, now_ms?: () => number) {
    const camera = signal("");
    super(
      {
        ask: () => cameras.ask(vehicle_id, camera.peek()),
        newest: () => cameras.newest(vehicle_id, camera.peek()),
      },
      now_ms,
    );
    this.camera = camera;
  }

  /** Shows another camera. */
  async choose(camera: string): Promise<void> {
    this.camera.value = camera;
    await this.ask();
  }

  /** What came last of the chosen camera: a picture of another one is not shown under its name. */
  get picture(): CameraPicture | null {
    const picture = this.shown.value?.picture ?? null;
    const camera = this.camera.value;
    return picture === null || (camera !== "" && picture.camera !== camera) ? null : picture;
  }
}

/** The picture as the source of an image; null if none came. */
export function sourceOf(picture: CameraPicture | null): string | null {
  return picture === null || !picture.jpeg ? null : `data:image/jpeg;base64,${picture.jpeg}`;
}
