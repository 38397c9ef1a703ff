import { signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../../shared/api/client";
import type { Problem, Result } from "../../../shared/api/problem";
import type { Track } from "./fleet_scene";

type FleetPositions = Readonly<Schemas["FleetPositions"]>;

/** Positions are loaded in pieces of time: fine ones, and coarse ones for quick replay. */
export interface Level {
  readonly length_ms: number;
  readonly step_ms: number;
}

export const FINE: Level = { length_ms: 60_000, step_ms: 1_000 };
export const COARSE: Level = { length_ms: 300_000, step_ms: 4_000 };
/** From this factor on a coarse piece is enough: a frame skips more than its step. */
export const COARSE_FROM_FACTOR = 30;
const KEPT = 40;
/** After a failure nothing is asked for so long: a replay asks at every frame. */
const RETRY_MS = 2_000;
/** Positions are stored within this time of when they came. */
const SETTLED_MS = 3_000;
/** A piece that reaches into the present is loaded again so much later. */
const GROWS_MS = 5_000;

export type Fetch = (
  from_ms: number,
  seconds: number,
  step_ms: number,
) => Promise<Result<FleetPositions>>;

/** The pieces that were loaded, and those that are on their way. */
export class FleetPieces {
  /** Grows with every piece that arrives, so that what is shown is made again. */
  readonly arrived = signal(0);
  readonly problem = signal<Problem | null>(null);

  private readonly kept = new Map<string, readonly Track[]>();
  private readonly awaited = new Set<string>();
  private retry_at_ms = 0;
  private retry: ReturnType<typeof setTimeout> | undefined;

  /** When a piece that was not over yet is loaded again, in this screen's own time. */
  private readonly outdated_ms = new Map<string, number>();

  /** now_ms: the server's clock. */
  constructor(
    private readonly now_ms: () => number,
    private readonly fetch: Fetch = fetchPositions,
  ) {}

  close(): void {
    clearTimeout(this.retry);
  }

  /** The tracks of the piece in which the moment lies; null while it is not there. */
  at(moment_ms: number, level: Level): readonly Track[] | null {
    return this.kept.get(nameOf(level, numberOf(moment_ms, level))) ?? null;
  }

  /** Loads the piece in which the moment lies, unless it is there, on its way, or has just failed. */
  async load(moment_ms: number, level: Level): Promise<void> {
    const number = numberOf(moment_ms, level);
    const name = nameOf(level, number);
    const is_outdated = performance.now() >= (this.outdated_ms.get(name) ?? Infinity);
    const is_too_soon = performance.now() < this.retry_at_ms;
    if ((this.kept.has(name) && !is_outdated) || this.awaited.has(name) || is_too_soon) return;
    this.awaited.add(name);
    const tracks = await this.loadTracks(number * level.length_ms, level);
    this.awaited.delete(name);
    if (tracks === null) {
      this.retry_at_ms = performance.now() + RETRY_MS;
      // While time stands nothing else would ask again.
      this.retry = setTimeout(() => void this.load(moment_ms, level), RETRY_MS + 1);
      return;
    }
    this.keep(name, tracks);
    const is_over = (number + 1) * level.length_ms < this.now_ms() - SETTLED_MS;
    if (is_over) this.outdated_ms.delete(name);
    else this.outdated_ms.set(name, performance.now() + GROWS_MS);
    this.arrived.value += 1;
  }

  private keep(name: string, tracks: readonly Track[]): void {
    this.kept.set(name, tracks);
    for (const oldest of this.kept.keys()) {
      if (this.kept.size <= KEPT) break;
      this.kept.delete(oldest);
    }
  }

  /** An answer may reach less far than asked; the rest is asked for. */
  private async loadTracks(start_ms: number, level: Level): Promise<readonly Track[] | null> {
    const end_ms = start_ms + level.length_ms;
    const whole = new Map<string, Track>();
    for (let from_ms = start_ms; from_ms < end_ms;) {
      const seconds = Math.ceil((end_ms - from_ms) / 1000);
      const result = await this.fetch(from_ms, seconds, level.step_ms);
      this.problem.value = result.ok ? null : result.problem;
      if (!result.ok) return null;
      for (const track of result.value.tracks)
        whole.set(track.vehicle_id, joined(whole.get(track.vehicle_id), track));
      from_ms = Math.max(result.value.to_ms, from_ms + 1);
    }
    return [...whole.values()];
  }
}

function numberOf(moment_ms: number, level: Level): number {
  return Math.floor(moment_ms / level.length_ms);
}

function nameOf(level: Level, number: number): string {
  return `${level.step_ms}/${number}`;
}

function joined(before: Track | undefined, after: Track): Track {
  if (before === undefined) return after;
  return {
    vehicle_id: after.vehicle_id,
    at_ms: [...before.at_ms, ...after.at_ms],
    x_m: [...before.x_m, ...after.x_m],
    y_m: [...before.y_m, ...after.y_m],
    yaw_rad: [...before.yaw_rad, ...after.yaw_rad],
    speed_mps: [...before.speed_mps, ...after.speed_mps],
    mode: [...before.mode, ...after.mode],
    battery_ratio: [...before.battery_ratio, ...after.battery_ratio],
  };
}

function fetchPositions(
  from_ms: number,
  seconds: number,
  step_ms: number,
): Promise<Result<FleetPositions>> {
  return resultOf(
    api.GET("/api/v1/replays/positions", { params: { query: { from_ms, seconds, step_ms } } }),
  ) as Promise<Result<FleetPositions>>;
}
