import { computed, effect, signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../../shared/api/client";
import type { Problem, Result } from "../../../shared/api/problem";
import { now_ms } from "../../texts/times";
import { PlaybackClock } from "../playback_clock";
import { COARSE, COARSE_FROM_FACTOR, FINE, FleetPieces, type Level } from "./fleet_pieces";
import { sceneOfPast, type Track } from "./fleet_scene";

type FleetPast = Readonly<Schemas["FleetPast"]>;

/** The past of the whole fleet as a source of scenes, with a time that the operator sets. */
export class FleetPlayer {
  readonly past = signal<FleetPast | null>(null);
  readonly past_problem = signal<Problem | null>(null);
  readonly pieces = new FleetPieces(now_ms);
  readonly clock: PlaybackClock;

  /** The tracks of this moment: fine ones if they are there, else coarse ones; null while none are. */
  readonly tracks = computed<readonly Track[] | null>(() => {
    void this.pieces.arrived.value;
    const at_ms = this.clock.at_ms.value;
    const [first, second] = this.level.value === FINE ? [FINE, COARSE] : [COARSE, FINE];
    return this.pieces.at(at_ms, first) ?? this.pieces.at(at_ms, second);
  });
  readonly scene = computed(() => {
    const { value: past } = this.past;
    if (past === null) return null;
    const { vehicles, rides } = past;
    return sceneOfPast(
      this.clock.at_ms.value,
      vehicles,
      this.tracks.value ?? [],
      rides,
      this.map_version,
    );
  });

  private readonly level = computed<Level>(() =>
    this.clock.playing.value && this.clock.speed_factor.value >= COARSE_FROM_FACTOR ? COARSE : FINE,
  );
  private readonly stop: () => void;

  constructor(
    readonly start_ms: number,
    readonly end_ms: number,
    first_ms: number,
    private readonly map_version: string,
  ) {
    this.clock = new PlaybackClock(() => ({ start_ms, end_ms, grows: false }));
    this.clock.seek(first_ms);
    void this.loadPast();
    this.stop = effect(() => {
      const [at_ms, level] = [this.clock.at_ms.value, this.level.value];
      void this.pieces.load(at_ms, level);
      if (this.clock.playing.value) void this.pieces.load(at_ms + level.length_ms, level);
    });
  }

  close(): void {
    this.stop();
    this.clock.close();
    this.pieces.close();
  }

  /** Ask for what happened in this time, again after a failure. */
  async loadPast(): Promise<void> {
    this.past_problem.value = null;
    const query = { from_ms: this.start_ms, seconds: (this.end_ms - this.start_ms) / 1000 };
    const result = (await resultOf(
      api.GET("/api/v1/replays/fleet", { params: { query } }),
    )) as Result<FleetPast>;
    if (result.ok) this.past.value = result.value;
    else this.past_problem.value = result.problem;
  }
}
