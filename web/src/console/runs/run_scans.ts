import { signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";

export type ScanMoment = Readonly<Schemas["ScanMoment"]>;

/** A scan is recorded once a second, and is shown for a bit longer. */
const SHOWN_MS = 1_500;
const STEP_MS = 1_000;
/** Seconds of scans that are kept. */
const KEPT = 60;
/** While the operator drags the slider, nothing is asked for. */
const SETTLE_MS = 120;

export type FetchScans = (from_ms: number, seconds: number) => Promise<Result<ScanMoment[]>>;

/** Scans beside the map, loaded only for the moments that the operator looks at, and only when asked for. */
export class RunScans {
  readonly shown = signal(false);
  /** Grows with every answer. */
  readonly arrived = signal(0);
  readonly problem = signal<Problem | null>(null);
  private readonly kept = new Map<number, readonly ScanMoment[]>();
  private readonly awaited = new Set<number>();
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly fetch: FetchScans) {}

  close(): void {
    clearTimeout(this.timer);
  }

  /** The newest scan at or before this moment; undefined while it is loaded, null if there is none. */
  at(at_ms: number): ScanMoment | null | undefined {
    const found = this.kept.get(Math.floor(at_ms / STEP_MS));
    if (found === undefined) return undefined;
    return found.findLast((scan) => scan.at_ms <= at_ms && at_ms - scan.at_ms < SHOWN_MS) ?? null;
  }

  /** Loads the scans around this moment if scans are shown; a moment that is dragged over is left out. */
  want(at_ms: number, playing: boolean): void {
    clearTimeout(this.timer);
    if (!this.shown.value) return;
    const number = Math.floor(at_ms / STEP_MS);
    if (playing) void this.load(number);
    else this.timer = setTimeout(() => void this.load(number), SETTLE_MS);
  }

  private async load(number: number): Promise<void> {
    if (this.kept.has(number) || this.awaited.has(number)) return;
    this.awaited.add(number);
    // The scan that is shown at the begin of this second may be of the ones before.
    const result = await this.fetch(Math.max(0, (number - 2) * STEP_MS), 3);
    this.awaited.delete(number);
    this.problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    this.kept.set(number, result.value);
    for (const oldest of this.kept.keys()) {
      if (this.kept.size <= KEPT) break;
      this.kept.delete(oldest);
    }
    this.arrived.value += 1;
  }
}

/** Shares of a scan's points on the map, on something new, and beyond walls of the map; in percent. */
export function scanShares({ agrees, new: fresh, through }: ScanMoment): {
  readonly agrees: number;
  readonly new: number;
  readonly through: number;
} {
  const count = Math.max(1, agrees.length + fresh.length + through.length);
  const percent = (part: readonly number[]) => Math.round((100 * part.length) / count);
  return { agrees: percent(agrees), new: percent(fresh), through: percent(through) };
}

/** Of a recorded run. */
export function scansOfRun(vehicle_id: string, boot_id: string): FetchScans {
  return (from_ms, seconds) =>
    resultOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/scans", {
        params: { path: { vehicle_id, boot_id }, query: { from_ms, seconds } },
      }),
    ) as Promise<Result<ScanMoment[]>>;
}
