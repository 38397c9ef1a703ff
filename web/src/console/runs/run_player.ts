import { computed, effect, signal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import type { CampusGeometry } from "../../shared/campus/campus_geometry";
import { campusGeometry } from "../../shared/campus/campus_geometry";
import type { Scene } from "../../shared/scene/scene";
import { type Mark, marksOfScenes } from "./marks";
import { inOrderOfTime, marksOfOperators } from "./operator_marks";
import { OnboardPieces, onboardOfRun } from "./onboard_pieces";
import { sceneAt } from "./playback";
import { PlaybackClock } from "./playback_clock";
import { RunScans, scansOfRun } from "./run_scans";
import { RunVideo, videoOf } from "./run_video";

const SCENES_PER_REQUEST = 3000;
const STEP_MS = 200;

/** A recorded run as a source of scenes, as live ones are, with a time that the operator sets. */
export class RunPlayer {
  readonly scenes = signal<readonly Scene[]>([]);
  readonly loading = signal(true);
  readonly problem = signal<Problem | null>(null);
  /** The map of the recording; null before it is loaded, or if it is missing. */
  readonly geometry = signal<CampusGeometry | null>(null);
  readonly map_problem = signal<Problem | null>(null);
  readonly clock = new PlaybackClock(() => ({
    start_ms: this.start_ms,
    end_ms: this.end_ms,
    grows: this.loading.value,
  }));
  readonly scene = computed(() => sceneAt(this.scenes.value, this.clock.at_ms.value));
  private readonly operator_marks = signal<readonly Mark[]>([]);
  readonly marks = computed(() =>
    inOrderOfTime(marksOfScenes(this.scenes.value), this.operator_marks.value),
  );

  readonly pieces: OnboardPieces;
  /** What the shuttle saw in detail; undefined while it is loaded, null if the recording has nothing. */
  readonly onboard = computed(() => {
    void this.pieces.arrived.value;
    return this.pieces.at(this.clock.at_ms.value);
  });
  readonly scans: RunScans;
  /** The scan of this moment beside the map; undefined while it is loaded or not asked for. */
  readonly scan = computed(() => {
    void this.scans.arrived.value;
    return this.scans.shown.value ? this.scans.at(this.clock.at_ms.value) : undefined;
  });
  readonly video: RunVideo;
  private closed = false;
  private readonly stop: () => void;

  constructor(
    private readonly vehicle_id: string,
    private readonly boot_id: string,
    /** Where to begin, if the run was recorded then. */
    private waits_for_ms: number | null = null,
  ) {
    this.pieces = new OnboardPieces(onboardOfRun(vehicle_id, boot_id));
    this.scans = new RunScans(scansOfRun(vehicle_id, boot_id));
    this.video = new RunVideo(videoOf(vehicle_id));
    this.stop = effect(() => {
      if (this.scenes.value.length === 0) return;
      this.pieces.want(this.clock.at_ms.value, this.clock.playing.value);
      this.scans.want(this.clock.at_ms.value, this.clock.playing.value);
    });
    void this.loadMap();
    void this.loadMarks();
    void this.load();
  }

  get start_ms(): number {
    return this.scenes.value[0]?.at_ms ?? 0;
  }

  get end_ms(): number {
    return this.scenes.value.at(-1)?.at_ms ?? 0;
  }

  /** Goes to a moment, at the latest when it is loaded. */
  show(at_ms: number | null): void {
    if (at_ms === null) return;
    if (at_ms <= this.end_ms || !this.loading.value) this.clock.seek(at_ms);
    else this.waits_for_ms = at_ms;
  }

  /** The moment that the link names is not loaded yet. */
  get is_on_the_way(): boolean {
    return this.waits_for_ms !== null;
  }

  close(): void {
    this.closed = true;
    this.stop();
    this.pieces.close();
    this.scans.close();
    this.clock.close();
  }

  private async loadMap(): Promise<void> {
    const path = { vehicle_id: this.vehicle_id, boot_id: this.boot_id };
    const result = await resultOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/map", { params: { path } }),
    );
    if (result.ok) this.geometry.value = campusGeometry(result.value);
    else this.map_problem.value = result.problem;
  }

  private async loadMarks(): Promise<void> {
    const path = { vehicle_id: this.vehicle_id, boot_id: this.boot_id };
    const result = await resultOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/marks", { params: { path } }),
    );
    if (result.ok) this.operator_marks.value = marksOfOperators(this.vehicle_id, result.value);
    else this.problem.value = result.problem;
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
      if (is_first) this.clock.seek(this.start_ms);
      from_ms = this.end_ms + 1;
      more = result.value.length === SCENES_PER_REQUEST;
      this.goToFirst(more);
    }
    this.loading.value = false;
  }

  /** Goes to where the link points as soon as that is loaded, unless the operator has begun to look around. */
  private goToFirst(more: boolean): void {
    if (this.waits_for_ms === null) return;
    if (this.clock.at_ms.value !== this.start_ms || this.clock.playing.value)
      this.waits_for_ms = null;
    else if (this.waits_for_ms <= this.end_ms || !more) {
      this.clock.seek(this.waits_for_ms);
      this.waits_for_ms = null;
    }
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
