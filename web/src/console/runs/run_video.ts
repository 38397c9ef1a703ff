import { signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";

export type VideoSegment = Readonly<Schemas["VideoSegmentView"]>;

/** The server answers for so much at once. */
const SPAN_MS = 6 * 3600 * 1000;
/** How far a playing video may be from the replay's time before it is set. */
const DRIFT_S = 0.3;
/** Browsers play no faster; beyond, the video jumps. */
const RATE_MAX = 16;

export type FetchVideo = (from_ms: number, to_ms: number) => Promise<Result<VideoSegment[]>>;

/** The video of a run: its segments are asked for once, when an operator wants to see them. */
export class RunVideo {
  readonly shown = signal(false);
  readonly loading = signal(false);
  readonly problem = signal<Problem | null>(null);
  readonly segments = signal<readonly VideoSegment[]>([]);

  constructor(private readonly fetch: FetchVideo) {}

  /** Who looks at video is in the audit log, so nothing is asked for before this. */
  async show(start_ms: number, end_ms: number): Promise<void> {
    this.shown.value = true;
    this.loading.value = true;
    const found = new Map<string, VideoSegment>();
    this.problem.value = null;
    for (let from_ms = start_ms; from_ms <= end_ms; from_ms += SPAN_MS) {
      const result = await this.fetch(from_ms, Math.min(end_ms, from_ms + SPAN_MS));
      if (!result.ok) {
        this.problem.value = result.problem;
        break;
      }
      for (const segment of result.value) found.set(segment.sha256, segment);
    }
    this.segments.value = [...found.values()];
    this.loading.value = false;
  }

  get cameras(): readonly string[] {
    return [...new Set(this.segments.value.map(({ camera }) => camera))].sort();
  }

  /** A camera's segment at a moment of the run, and how far into it; null if none has come. */
  at(
    camera: string,
    at_ms: number,
  ): { readonly segment: VideoSegment; readonly at_s: number } | null {
    const segment = this.segments.value.find(
      (one) =>
        one.camera === camera &&
        Date.parse(one.begins_at) <= at_ms &&
        at_ms <= Date.parse(one.ends_at),
    );
    if (segment === undefined) return null;
    return { segment, at_s: (at_ms - Date.parse(segment.begins_at)) / 1000 };
  }
}

/** What a video element is set to, so that it shows the replay's moment. */
export function following(
  video: { readonly currentTime: number; readonly paused: boolean },
  at_s: number,
  playing: boolean,
  speed_factor: number,
): { readonly seek_s: number | null; readonly play: boolean; readonly rate: number } {
  const play = playing && speed_factor <= RATE_MAX;
  const drift_s = Math.abs(video.currentTime - at_s);
  const allowed_s = play ? DRIFT_S * Math.max(1, speed_factor) : 0.04;
  return {
    seek_s: drift_s > allowed_s ? at_s : null,
    play,
    rate: Math.min(speed_factor, RATE_MAX),
  };
}

export function videoOf(vehicle_id: string): FetchVideo {
  return async (from_ms, to_ms) => {
    const result = await resultOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/video-views", {
        params: { path: { vehicle_id } },
        body: { begin: new Date(from_ms).toISOString(), end: new Date(to_ms).toISOString() },
      }),
    );
    return result.ok
      ? { ok: true, value: (result.value as Schemas["VideoView"]).segments }
      : result;
  };
}
